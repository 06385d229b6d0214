// Marks beside the surfaces: contact points, key points, the chosen pair, boxes.
import * as THREE from 'three';
import { kBlue, kOrange, kSky, timeColor, type Rgb } from '../shared/colors';
import type { Pair } from './api';
import { kBoxVertex, kFlatFragment, kLineVertex, kPointFragment, kPointVertex } from './shaders';
import { rampOf, vec3, type Surface } from './surface';

const kEverywhere = new THREE.Sphere(new THREE.Vector3(), 1e9);
const kHidden = 0.2; // opacity of marks behind a surface

const kNear = 2; // Contact points are shown from nearer than this; what is seen from afar has size 2.

/** Draws the same points twice: opaque where visible, faint where hidden. */
function pointLayer(geometry: THREE.BufferGeometry, uniforms: Record<string, THREE.IUniform>, byVertex: boolean): THREE.Group {
  geometry.boundingSphere = kEverywhere;
  const group = new THREE.Group();
  for (const hidden of [true, false]) {
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: kPointVertex,
      fragmentShader: kPointFragment,
      defines: byVertex ? { BY_VERTEX: 1 } : {},
      transparent: true,
      depthTest: !hidden,
      depthWrite: false,
      uniforms: { farthest: { value: 1e9 }, ...uniforms, opacity: { value: hidden ? kHidden : 1 } },
    });
    const points = new THREE.Points(geometry, material);
    points.frustumCulled = false;
    points.renderOrder = hidden ? 4 : 5;
    group.add(points);
  }
  return group;
}

export class ContactPoints {
  readonly group: THREE.Group;
  private readonly geometry = new THREE.BufferGeometry();
  private readonly uniforms;
  private capacity = 0;

  constructor(
    private readonly center: THREE.Vector3,
    private readonly scale: number,
    private readonly ratio: number,
    positionUniforms: Record<string, THREE.IUniform>,
  ) {
    this.uniforms = { ...positionUniforms, timeRamp: { value: rampOf(timeColor) }, now: { value: 0 }, firstTime: { value: 0 }, lastTime: { value: 1 }, size: { value: 10 * ratio }, farthest: { value: kNear } };
    this.group = pointLayer(this.geometry, this.uniforms, false);
    this.reserve(1024);
  }

  private reserve(count: number): void {
    this.capacity = count;
    this.geometry.dispose();
    this.geometry.setAttribute('position_', new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    this.geometry.setAttribute('toi', new THREE.BufferAttribute(new Float32Array(count), 1));
  }

  set(pairs: Pair[]): void {
    if (pairs.length > this.capacity) this.reserve(Math.max(pairs.length, 2 * this.capacity));
    const points = this.geometry.getAttribute('position_') as THREE.BufferAttribute;
    const times = this.geometry.getAttribute('toi') as THREE.BufferAttribute;
    const { center, scale } = this;
    pairs.forEach((pair, k) => {
      const [x, y, z] = pair.point as [number, number, number];
      points.setXYZ(k, (x - center.x) * scale, (y - center.y) * scale, (z - center.z) * scale);
      times.setX(k, pair.toi);
    });
    this.uniforms.firstTime.value = pairs[0]?.toi ?? 0;
    this.uniforms.lastTime.value = pairs.length > 1 ? pairs.at(-1)!.toi : 2; // A single point is the first.
    // Many points show where, few show which.
    this.uniforms.size.value = this.ratio * (pairs.length > 400 ? 6 : pairs.length > 60 ? 8 : 11);
    points.needsUpdate = true;
    times.needsUpdate = true;
    this.geometry.setDrawRange(0, pairs.length);
  }

  setTime(t: number): void {
    this.uniforms.now.value = t;
  }
}

export function keyPoints(surface: Surface, ids: number[], ratio: number): THREE.Group {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('vertex', new THREE.BufferAttribute(Uint32Array.from(ids), 1));
  geometry.setDrawRange(0, ids.length);
  return pointLayer(geometry, { ...surface.positionUniforms, only: { value: vec3(kSky) }, size: { value: (ids.length > 200 ? 5.5 : 8) * ratio } }, true);
}

/** The edges of a triangle. */
function outline(surface: Surface, face: number): [number, number][] {
  const [p, q, r] = surface.triangles.subarray(3 * face, 3 * face + 3) as unknown as [number, number, number];
  return [[p, q], [q, r], [r, p]];
}

/** The chosen pair's edges, over everything; the first feature is orange, the second blue. */
export class PairLines {
  readonly group = new THREE.Group();

  constructor(private readonly viewport: THREE.IUniform) {}

  clear(): void {
    for (const child of this.group.children) {
      const mesh = child as THREE.Mesh;
      mesh.geometry.dispose();
      (mesh.material as THREE.Material).dispose();
    }
    this.group.clear();
  }

  show(surfaces: Surface[], pair: Pair): void {
    this.clear();
    const a = surfaces[pair.object_a];
    const b = surfaces[pair.object_b];
    if (!a || !b) return;
    if (pair.kind === 'ee') {
      this.add(a, [[pair.a[0]!, pair.a[1]!]], kOrange);
      this.add(b, [[pair.b[0]!, pair.b[1]!]], kBlue);
    } else {
      this.add(b, outline(b, pair.b[0]!), kBlue);
      this.add(a, pair.kind === 'tt' ? outline(a, pair.a[0]!) : [[pair.a[0]!, pair.a[0]!]], kOrange);
    }
  }

  private add(surface: Surface, lines: [number, number][], color: Rgb): void {
    const from: number[] = [];
    const to: number[] = [];
    const end: number[] = [];
    const across: number[] = [];
    for (const [p, q] of lines) {
      for (const [e, s] of [[0, -1], [1, -1], [1, 1], [0, -1], [1, 1], [0, 1]] as const) {
        from.push(p);
        to.push(q);
        end.push(e);
        across.push(s);
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('from', new THREE.BufferAttribute(Uint32Array.from(from), 1));
    geometry.setAttribute('to', new THREE.BufferAttribute(Uint32Array.from(to), 1));
    geometry.setAttribute('end', new THREE.BufferAttribute(Float32Array.from(end), 1));
    geometry.setAttribute('across', new THREE.BufferAttribute(Float32Array.from(across), 1));
    geometry.setDrawRange(0, from.length);
    geometry.boundingSphere = kEverywhere;
    const dot = lines.length === 1 && lines[0]![0] === lines[0]![1];
    for (const rim of [true, false]) {
      const width = (dot ? 7 : 2.5) + (rim ? 1.5 : 0);
      const material = new THREE.ShaderMaterial({
        glslVersion: THREE.GLSL3,
        vertexShader: kLineVertex,
        fragmentShader: kFlatFragment,
        transparent: true,
        depthTest: false,
        side: THREE.DoubleSide,
        uniforms: { ...surface.positionUniforms, viewport: this.viewport, width: { value: width }, only: { value: rim ? new THREE.Vector3(1, 1, 1) : vec3(color) }, opacity: { value: 1 } },
      });
      const mesh = new THREE.Mesh(geometry, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = rim ? 6 : 7;
      this.group.add(mesh);
    }
  }
}

/** The boxes of one object, as lines. */
export class Boxes {
  readonly lines: THREE.LineSegments;
  private readonly geometry = new THREE.InstancedBufferGeometry();

  constructor(scale: number) {
    const corners: number[] = [];
    for (let axis = 0; axis < 3; ++axis) {
      for (let k = 0; k < 4; ++k) {
        for (const end of [0, 1]) {
          const corner = [0, 0, 0];
          corner[axis] = end;
          corner[(axis + 1) % 3] = k & 1;
          corner[(axis + 2) % 3] = k >> 1;
          corners.push(...corner);
        }
      }
    }
    this.geometry.setAttribute('corner', new THREE.BufferAttribute(Float32Array.from(corners), 3));
    this.geometry.setDrawRange(0, 24);
    this.geometry.boundingSphere = kEverywhere;
    this.geometry.instanceCount = 0;
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: kBoxVertex,
      fragmentShader: kFlatFragment,
      transparent: true,
      depthWrite: false,
      uniforms: { scale: { value: scale }, only: { value: vec3(kBlue) }, opacity: { value: 0.7 } },
    });
    this.lines = new THREE.LineSegments(this.geometry, material);
    this.lines.frustumCulled = false;
    this.lines.visible = false;
  }

  set(boxes: Float32Array): void {
    const data = new THREE.InstancedInterleavedBuffer(boxes, 6);
    this.geometry.dispose();
    this.geometry.setAttribute('low', new THREE.InterleavedBufferAttribute(data, 3, 0));
    this.geometry.setAttribute('high', new THREE.InterleavedBufferAttribute(data, 3, 3));
    this.geometry.instanceCount = boxes.length / 6;
  }

  color(color: Rgb): void {
    ((this.lines.material as THREE.ShaderMaterial).uniforms['only']!.value as THREE.Vector3).copy(vec3(color));
  }
}
