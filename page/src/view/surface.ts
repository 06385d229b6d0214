// One object's surface: positions and what is told of its triangles live in textures, see shaders.ts.
import * as THREE from 'three';
import { errorColour, kClay, kGrey, kNothingToProve, kObjectColours, kPink, kPurple, kReasons, kRed, marginColour, type Rgb } from '../shared/colours';
import type { ObjectInfo } from './api';
import { kSurfaceFragment, kSurfaceVertex } from './shaders';

const kRow = 2048; // Texels in a row; every WebGL 2 has room for 2048 rows of them.

export const floatsOf = (vertices: number): number => Math.ceil(vertices / kRow) * kRow * 3;
export const faceBytesOf = (triangles: number): number => Math.ceil((4 * triangles) / kRow) * kRow;

export const vec3 = ([r, g, b]: Rgb): THREE.Vector3 => new THREE.Vector3(r / 255, g / 255, b / 255);
export const rampOf = (colour: (value: number) => Rgb): THREE.Vector3[] =>
  Array.from({ length: 9 }, (_, k) => vec3(colour(k / 8)));

/** A texture that takes whole arrays of positions and knows which it has. */
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
  take(data: Float32Array<ArrayBuffer>, tag: string): void {
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

/** Two neighbouring frames; going on from one to the next uploads only what is new. */
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
    if (this.a.tag !== tagA) this.a.take(dataA, tagA);
    if (this.b.tag !== tagB) this.b.take(dataB, tagB);
  }
}

export interface Poses {
  data: Float32Array<ArrayBuffer>;
  tag: string; // what it is, for as long as the tag is in use
}

export type Paint = 'plain' | 'level' | 'margin' | 'error';
const kPaints: Paint[] = ['plain', 'level', 'margin', 'error'];

export class Surface {
  readonly mesh: THREE.Mesh;
  /** Shared with what is drawn at vertices of this object. */
  readonly place: Record<'posA' | 'posB' | 'blend' | 'centre' | 'scale', THREE.IUniform>;
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
    frame: { centre: THREE.Vector3; scale: number },
  ) {
    this.shown = new FramePair(floatsOf(info.vertices));
    this.faces = new THREE.DataTexture(new Uint8Array(kRow), kRow, 1, THREE.RedIntegerFormat, THREE.UnsignedByteType);
    this.faces.needsUpdate = true; // A texture that was never uploaded would be bound as one of another type.
    this.crossTexture = new THREE.DataTexture(new Uint8Array(kRow), kRow, 1, THREE.RedIntegerFormat, THREE.UnsignedByteType);
    this.crossTexture.needsUpdate = true;
    this.place = {
      posA: { value: this.shown.a.uniform },
      posB: { value: this.shown.b.uniform },
      blend: { value: 0 },
      centre: { value: frame.centre },
      scale: { value: frame.scale },
    };
    this.material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: kSurfaceVertex,
      fragmentShader: kSurfaceFragment,
      side: THREE.DoubleSide,
      uniforms: {
        ...this.place,
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
        plain: { value: vec3(kObjectColours[index % kObjectColours.length] ?? kClay) },
        red: { value: vec3(kRed) },
        pink: { value: vec3(kPink) },
        purple: { value: vec3(kPurple) },
        nothing: { value: vec3(kNothingToProve) },
        reasonColours: { value: Array.from({ length: 8 }, (_, k) => vec3(kReasons[reasons[k] ?? '']?.colour ?? kGrey)) },
        marginRamp: { value: rampOf(marginColour) },
        errorRamp: { value: rampOf(errorColour) },
        edges: { value: false },
        edgeColour: { value: new THREE.Vector3(0.08, 0.1, 0.12) },
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

  /** The two poses between which the surface is drawn. */
  pose(a: Poses, b: Poses, blend: number): void {
    this.shown.set(a.data, a.tag, b.data, b.tag);
    this.place.posA.value = this.shown.a.uniform;
    this.place.posB.value = this.shown.b.uniform;
    this.place.blend.value = blend;
  }

  /** The two poses that errors are measured from. */
  reference(a: Poses, b: Poses): void {
    this.other ??= new FramePair(floatsOf(this.info.vertices));
    this.other.set(a.data, a.tag, b.data, b.tag);
    this.set('refA', this.other.a.uniform);
    this.set('refB', this.other.b.uniform);
  }

  /** What is told of the triangles in the present step; null: nothing (yet). */
  tell(data: Uint8Array<ArrayBuffer> | null, changed: boolean): void {
    this.set('hasFaces', data !== null);
    if (data === null || (data === this.faceSource && !changed)) return;
    this.faceSource = data;
    if (this.faces.image.height !== data.length / kRow) this.faces.dispose();
    this.faces.image = { data, width: kRow, height: data.length / kRow };
    this.faces.needsUpdate = true;
  }

  /** Which triangles cross others in the first frame, one byte each. */
  cross(data: Uint8Array<ArrayBuffer>): void {
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

  /** How many triangles cross in the first frame; nothing until it is known. */
  crossingFaces: number | null = null;

  paint(options: { paint: Paint; collisions: boolean; crossings: boolean; edges: boolean; seeThrough: boolean; errorScale: number; edgeColour: Rgb }): void {
    this.set('surface', kPaints.indexOf(options.paint));
    this.set('showCollisions', options.collisions);
    this.set('showCrossings', options.crossings && this.crossing !== null);
    this.set('edges', options.edges);
    this.set('seeThrough', options.seeThrough);
    this.set('errorScale', options.errorScale);
    (this.material.uniforms['edgeColour']!.value as THREE.Vector3).copy(vec3(options.edgeColour));
  }

  /** Where a vertex is now, in mesh units. */
  vertex(v: number, out: THREE.Vector3): THREE.Vector3 {
    const { data: a } = this.shown.a;
    const { data: b } = this.shown.b;
    const t = this.place.blend.value as number;
    const k = 3 * v;
    return out.set(a[k]! + t * (b[k]! - a[k]!), a[k + 1]! + t * (b[k + 1]! - a[k + 1]!), a[k + 2]! + t * (b[k + 2]! - a[k + 2]!));
  }

  /** Whether a ray in mesh units meets a triangle farther away than `least`. */
  blocks(ray: THREE.Ray, least: number): boolean {
    const [p, q, r, at] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    for (let face = 0; face < this.info.triangles; ++face) {
      this.vertex(this.triangles[3 * face]!, p);
      this.vertex(this.triangles[3 * face + 1]!, q);
      this.vertex(this.triangles[3 * face + 2]!, r);
      if (ray.intersectTriangle(p, q, r, false, at) && at.distanceTo(ray.origin) > least) return true;
    }
    return false;
  }

  /** The first triangle that a ray in mesh units meets. A look at each: it is a click, not a frame. */
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
