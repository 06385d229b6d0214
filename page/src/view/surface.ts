// One object's surface. Positions and data of triangles are in textures, see shaders.ts.
import * as THREE from 'three';
import { errorColor, kClay, kGray, kNothingToProve, kObjectColors, kPink, kPurple, kReasons, kRed, marginColor, type Rgb } from '../shared/colors';
import type { ObjectInfo } from './api';
import { kSurfaceFragment, kSurfaceVertex } from './shaders';

const kRow = 2048; // Texels in a row; every WebGL 2 supports 2048 rows.

export const floatsOf = (vertices: number): number => Math.ceil(vertices / kRow) * kRow * 3;
export const faceBytesOf = (triangles: number): number => Math.ceil((4 * triangles) / kRow) * kRow;

export const vec3 = ([r, g, b]: Rgb): THREE.Vector3 => new THREE.Vector3(r / 255, g / 255, b / 255);
export const rampOf = (color: (value: number) => Rgb): THREE.Vector3[] =>
  Array.from({ length: 9 }, (_, k) => vec3(color(k / 8)));

/** A texture of positions, with a tag for its current content. */
class Positions {
  private readonly texture: THREE.DataTexture;
  data: Float32Array<ArrayBuffer>;
  tag = '';

  constructor(private readonly floats: number) {
    this.data = new Float32Array(floats);
    this.texture = new THREE.DataTexture(this.data, kRow, floats / 3 / kRow, THREE.RGBFormat, THREE.FloatType);
    this.texture.internalFormat = 'RGB32F';
    this.texture.needsUpdate = true;
  }
  get uniform(): THREE.DataTexture {
    return this.texture;
  }
  set(data: Float32Array<ArrayBuffer>, tag: string): void {
    if (data.length !== this.floats) throw new Error('positions of another size');
    this.data = data;
    this.texture.image.data = data;
    this.texture.needsUpdate = true;
    this.tag = tag;
  }
  dispose(): void {
    this.texture.dispose();
  }
}

/** Two adjacent frames; moving on by one frame uploads only the new one. */
class FramePair {
  a: Positions;
  b: Positions;
  constructor(floats: number) {
    this.a = new Positions(floats);
    this.b = new Positions(floats);
  }
  set(dataA: Float32Array<ArrayBuffer>, tagA: string, dataB: Float32Array<ArrayBuffer>, tagB: string): void {
    if (this.a.tag !== tagA && this.b.tag === tagA) [this.a, this.b] = [this.b, this.a];
    else if (this.b.tag !== tagB && this.a.tag === tagB && tagA !== tagB) [this.a, this.b] = [this.b, this.a];
    if (this.a.tag !== tagA) this.a.set(dataA, tagA);
    if (this.b.tag !== tagB) this.b.set(dataB, tagB);
  }
}

export interface Poses {
  data: Float32Array<ArrayBuffer>;
  tag: string; // identifies the content
}

export type Paint = 'plain' | 'level' | 'margin' | 'error';
const kPaints: Paint[] = ['plain', 'level', 'margin', 'error'];

export class Surface {
  readonly mesh: THREE.Mesh;
  /** Uniforms that give vertex positions, shared with marks at vertices of this object. */
  readonly positionUniforms: Record<'posA' | 'posB' | 'blend' | 'center' | 'scale', THREE.IUniform>;
  private readonly material: THREE.ShaderMaterial;
  private readonly shown: FramePair;
  private other: FramePair | null = null;
  private readonly faces: THREE.DataTexture;
  private faceSource: Uint8Array<ArrayBuffer> | null = null;
  private readonly crossTexture: THREE.DataTexture;
  private crossing: Uint8Array<ArrayBuffer> | null = null;

  constructor(
    readonly info: ObjectInfo,
    readonly index: number,
    readonly triangles: Uint32Array,
    reasons: string[],
    frame: { center: THREE.Vector3; scale: number },
  ) {
    this.shown = new FramePair(floatsOf(info.vertices));
    this.faces = new THREE.DataTexture(new Uint8Array(kRow), kRow, 1, THREE.RedIntegerFormat, THREE.UnsignedByteType);
    this.faces.needsUpdate = true; // An integer texture without an upload would be bound as another type.
    this.crossTexture = new THREE.DataTexture(new Uint8Array(kRow), kRow, 1, THREE.RedIntegerFormat, THREE.UnsignedByteType);
    this.crossTexture.needsUpdate = true;
    this.positionUniforms = {
      posA: { value: this.shown.a.uniform },
      posB: { value: this.shown.b.uniform },
      blend: { value: 0 },
      center: { value: frame.center },
      scale: { value: frame.scale },
    };
    this.material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: kSurfaceVertex,
      fragmentShader: kSurfaceFragment,
      side: THREE.DoubleSide,
      uniforms: {
        ...this.positionUniforms,
        refA: { value: this.shown.a.uniform },
        refB: { value: this.shown.b.uniform },
        faces: { value: this.faces },
        triangles: { value: info.triangles },
        surface: { value: 0 },
        hasFaces: { value: false },
        showCollisions: { value: true },
        crosses: { value: this.crossTexture },
        showCrossings: { value: false },
        errorScale: { value: 1 },
        plain: { value: vec3(kObjectColors[index % kObjectColors.length] ?? kClay) },
        red: { value: vec3(kRed) },
        pink: { value: vec3(kPink) },
        purple: { value: vec3(kPurple) },
        nothing: { value: vec3(kNothingToProve) },
        reasonColors: { value: Array.from({ length: 8 }, (_, k) => vec3(kReasons[reasons[k] ?? '']?.color ?? kGray)) },
        marginRamp: { value: rampOf(marginColor) },
        errorRamp: { value: rampOf(errorColor) },
        edges: { value: false },
        edgeColor: { value: new THREE.Vector3(0.08, 0.1, 0.12) },
        seeThrough: { value: false },
      },
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('vertex', new THREE.BufferAttribute(triangles, 1));
    geometry.setDrawRange(0, triangles.length);
    geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(), 1e9);
    this.mesh = new THREE.Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
  }

  private set(name: string, value: unknown): boolean {
    const uniform = this.material.uniforms[name]!;
    if (uniform.value === value) return false;
    uniform.value = value;
    return true;
  }

  /** Sets the two poses between which the surface is interpolated. */
  pose(a: Poses, b: Poses, blend: number): void {
    this.shown.set(a.data, a.tag, b.data, b.tag);
    this.positionUniforms.posA.value = this.shown.a.uniform;
    this.positionUniforms.posB.value = this.shown.b.uniform;
    this.positionUniforms.blend.value = blend;
  }

  /** Sets the two poses from which errors are measured. */
  reference(a: Poses, b: Poses): void {
    this.other ??= new FramePair(floatsOf(this.info.vertices));
    this.other.set(a.data, a.tag, b.data, b.tag);
    this.set('refA', this.other.a.uniform);
    this.set('refB', this.other.b.uniform);
  }

  /** Sets the data of the triangles in the current step; null if there is none (yet). */
  setFaces(data: Uint8Array<ArrayBuffer> | null, changed: boolean): void {
    this.set('hasFaces', data !== null);
    if (data === null || (data === this.faceSource && !changed)) return;
    this.faceSource = data;
    if (this.faces.image.height !== data.length / kRow) this.faces.dispose();
    this.faces.image = { data, width: kRow, height: data.length / kRow };
    this.faces.needsUpdate = true;
  }

  /** Sets which triangles cross others in the first frame, one byte each. */
  setCrossingFaces(data: Uint8Array<ArrayBuffer>): void {
    const padded = new Uint8Array(Math.ceil(data.length / kRow) * kRow);
    padded.set(data);
    this.crossing = data;
    this.crossingFaces = data.reduce((sum, one) => sum + one, 0);
    this.crossTexture.dispose();
    this.crossTexture.image = { data: padded, width: kRow, height: padded.length / kRow };
    this.crossTexture.needsUpdate = true;
  }

  crosses(face: number): boolean {
    return this.crossing !== null && this.crossing[face] !== 0;
  }

  /** The number of triangles that cross in the first frame; null until known. */
  crossingFaces: number | null = null;

  paint(options: { paint: Paint; collisions: boolean; crossings: boolean; edges: boolean; seeThrough: boolean; errorScale: number; edgeColor: Rgb }): void {
    this.set('surface', kPaints.indexOf(options.paint));
    this.set('showCollisions', options.collisions);
    this.set('showCrossings', options.crossings && this.crossing !== null);
    this.set('edges', options.edges);
    this.set('seeThrough', options.seeThrough);
    this.set('errorScale', options.errorScale);
    (this.material.uniforms['edgeColor']!.value as THREE.Vector3).copy(vec3(options.edgeColor));
  }

  /** The current position of a vertex, in mesh units. */
  vertex(v: number, out: THREE.Vector3): THREE.Vector3 {
    const { data: a } = this.shown.a;
    const { data: b } = this.shown.b;
    const t = this.positionUniforms.blend.value as number;
    const k = 3 * v;
    return out.set(a[k]! + t * (b[k]! - a[k]!), a[k + 1]! + t * (b[k + 1]! - a[k + 1]!), a[k + 2]! + t * (b[k + 2]! - a[k + 2]!));
  }

  /** Whether a ray in mesh units hits a triangle farther away than `minDistance`. */
  blocks(ray: THREE.Ray, minDistance: number): boolean {
    const [p, q, r, at] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    for (let face = 0; face < this.info.triangles; ++face) {
      this.vertex(this.triangles[3 * face]!, p);
      this.vertex(this.triangles[3 * face + 1]!, q);
      this.vertex(this.triangles[3 * face + 2]!, r);
      if (ray.intersectTriangle(p, q, r, false, at) && at.distanceTo(ray.origin) > minDistance) return true;
    }
    return false;
  }

  /** The first triangle that a ray in mesh units hits. Tests all triangles, which is fast enough for a click. */
  hit(ray: THREE.Ray): { face: number; point: THREE.Vector3; distance: number } | null {
    const [p, q, r, at] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    let best: { face: number; point: THREE.Vector3; distance: number } | null = null;
    for (let face = 0; face < this.info.triangles; ++face) {
      this.vertex(this.triangles[3 * face]!, p);
      this.vertex(this.triangles[3 * face + 1]!, q);
      this.vertex(this.triangles[3 * face + 2]!, r);
      if (!ray.intersectTriangle(p, q, r, false, at)) continue;
      const distance = at.distanceTo(ray.origin);
      if (!best || distance < best.distance) best = { face, point: at.clone(), distance };
    }
    return best;
  }
}
