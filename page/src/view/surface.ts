// One object's surface. Positions and data of triangles are in textures, see shaders.ts.
import * as THREE from 'three';
import { errorColor, kBlue, kClay, kGray, kNothingToProve, kObjectColors, kPink, kReasons, kRed, kYellow, marginColor, type Rgb } from '../shared/colors';
import type { ObjectInfo } from './api';
import { vertexNormals } from './normals';
import { kSurfaceFragment, kSurfaceVertex } from './shaders';

const kRow = 2048; // Texels in a row; every WebGL 2 supports 2048 rows.

export const floatsOf = (vertices: number): number => Math.ceil(vertices / kRow) * kRow * 3;
export const faceBytesOf = (triangles: number): number => Math.ceil((4 * triangles) / kRow) * kRow;

export const vec3 = ([r, g, b]: Rgb): THREE.Vector3 => new THREE.Vector3(r / 255, g / 255, b / 255);
export const rampOf = (color: (value: number) => Rgb): THREE.Vector3[] =>
  Array.from({ length: 9 }, (_, k) => vec3(color(k / 8)));

function vectorTexture(data: Float32Array<ArrayBuffer>): THREE.DataTexture {
  const texture = new THREE.DataTexture(data, kRow, data.length / 3 / kRow, THREE.RGBFormat, THREE.FloatType);
  texture.internalFormat = 'RGB32F';
  texture.needsUpdate = true;
  return texture;
}

/** A small integer per triangle or vertex. */
function markTexture(): THREE.DataTexture {
  const texture = new THREE.DataTexture(new Uint8Array(kRow), kRow, 1, THREE.RedIntegerFormat, THREE.UnsignedByteType);
  texture.needsUpdate = true; // An integer texture without an upload would be bound as another type.
  return texture;
}

function setMarks(texture: THREE.DataTexture, marks: Uint8Array): void {
  const padded = new Uint8Array(Math.ceil(marks.length / kRow) * kRow);
  padded.set(marks);
  if (texture.image.height !== padded.length / kRow) texture.dispose();
  texture.image = { data: padded, width: kRow, height: padded.length / kRow };
  texture.needsUpdate = true;
}

/** Textures of positions and normals, with a tag for their current content. */
class Positions {
  readonly texture: THREE.DataTexture;
  readonly normals: THREE.DataTexture;
  data: Float32Array<ArrayBuffer>;
  tag = '';

  constructor(
    private readonly floats: number,
    private readonly triangles: Uint32Array | null, // null: without normals
  ) {
    this.data = new Float32Array(floats);
    this.texture = vectorTexture(this.data);
    this.normals = vectorTexture(new Float32Array(triangles ? floats : 3 * kRow));
  }
  set(data: Float32Array<ArrayBuffer>, tag: string): void {
    if (data.length !== this.floats) throw new Error('positions of another size');
    this.data = data;
    this.texture.image.data = data;
    this.texture.needsUpdate = true;
    this.tag = tag;
    if (!this.triangles) return;
    vertexNormals(data, this.triangles, this.normals.image.data as Float32Array);
    this.normals.needsUpdate = true;
  }
}

/** Two adjacent frames; moving on by one frame uploads only the new one. */
class FramePair {
  a: Positions;
  b: Positions;
  constructor(floats: number, triangles: Uint32Array | null) {
    this.a = new Positions(floats, triangles);
    this.b = new Positions(floats, triangles);
  }
  set(dataA: Float32Array<ArrayBuffer>, tagA: string, dataB: Float32Array<ArrayBuffer>, tagB: string): void {
    if (this.a.tag !== tagA && this.b.tag === tagA) [this.a, this.b] = [this.b, this.a];
    else if (this.b.tag !== tagB && this.a.tag === tagB && tagA !== tagB) [this.a, this.b] = [this.b, this.a];
    if (this.a.tag !== tagA) this.a.set(dataA, tagA);
    if (this.b.tag !== tagB) this.b.set(dataB, tagB);
  }
}

/** The chosen contact and the plane that cuts, common to all surfaces. */
export interface FocusUniforms extends Record<string, THREE.IUniform> {
  focus: THREE.IUniform<THREE.Vector4>;
  nearSide: THREE.IUniform<number>;
  clip: THREE.IUniform<THREE.Vector4>;
}

export interface Poses {
  data: Float32Array<ArrayBuffer>;
  tag: string; // identifies the content
}

export type Paint = 'plain' | 'level' | 'margin' | 'error' | 'correction'; // the last two are distances from a reference
const kPaints: Paint[] = ['plain', 'level', 'margin', 'error'];

export class Surface {
  readonly mesh: THREE.Mesh;
  /** Marked triangles that are hidden, shining through. */
  readonly glow: THREE.Mesh;
  /** What is see-through: its depth, then its nearest layer. */
  private readonly ghosts: THREE.Mesh[];
  /** Uniforms that give vertex positions, shared with marks at vertices of this object. */
  readonly positionUniforms: Record<'posA' | 'posB' | 'blend' | 'scale', THREE.IUniform>;
  private readonly material: THREE.ShaderMaterial;
  private readonly shown: FramePair;
  private other: FramePair | null = null;
  private readonly faces: THREE.DataTexture;
  private faceSource: Uint8Array<ArrayBuffer> | null = null;
  private readonly contactTexture = markTexture();
  private readonly paintedTexture = markTexture();

  constructor(
    readonly info: ObjectInfo,
    readonly index: number,
    readonly triangles: Uint32Array,
    reasons: string[],
    scale: number,
    focus: FocusUniforms,
  ) {
    this.shown = new FramePair(floatsOf(info.vertices), triangles);
    this.faces = markTexture();
    this.positionUniforms = {
      posA: { value: this.shown.a.texture },
      posB: { value: this.shown.b.texture },
      blend: { value: 0 },
      scale: { value: scale },
    };
    this.material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: kSurfaceVertex,
      fragmentShader: kSurfaceFragment,
      side: THREE.DoubleSide,
      uniforms: {
        ...this.positionUniforms,
        ...focus,
        normalA: { value: this.shown.a.normals },
        normalB: { value: this.shown.b.normals },
        refA: { value: this.shown.a.texture },
        refB: { value: this.shown.b.texture },
        contact: { value: this.contactTexture },
        showContact: { value: false },
        painted: { value: this.paintedTexture },
        showPainted: { value: false },
        paintedColor: { value: vec3(kYellow) },
        first: { value: vec3(kRed) },
        second: { value: vec3(kBlue) },
        faces: { value: this.faces },
        triangles: { value: info.triangles },
        surface: { value: 0 },
        hasFaces: { value: false },
        showInside: { value: true },
        showMeets: { value: true },
        insideBit: { value: 2 },
        errorScale: { value: 1 },
        plain: { value: vec3(kObjectColors[index % kObjectColors.length] ?? kClay) },
        red: { value: vec3(kRed) },
        pink: { value: vec3(kPink) },
        nothing: { value: vec3(kNothingToProve) },
        reasonColors: { value: Array.from({ length: 8 }, (_, k) => vec3(kReasons[reasons[k] ?? '']?.color ?? kGray)) },
        marginRamp: { value: rampOf(marginColor) },
        errorRamp: { value: rampOf(errorColor) },
        edges: { value: false },
        edgeColor: { value: new THREE.Vector3(0.08, 0.1, 0.12) },
        seeThrough: { value: false },
        order: { value: (index % 8) / 8 },
      },
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('vertex', new THREE.BufferAttribute(triangles, 1));
    geometry.setDrawRange(0, triangles.length);
    geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(), 1e9);
    this.mesh = new THREE.Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
    const hidden = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: kSurfaceVertex,
      fragmentShader: kSurfaceFragment,
      defines: { GLOW: 1 },
      uniforms: this.material.uniforms,
      side: THREE.DoubleSide,
      transparent: true,
      depthFunc: THREE.GreaterDepth,
      depthWrite: false,
    });
    this.glow = new THREE.Mesh(geometry, hidden);
    this.glow.frustumCulled = false;
    this.glow.renderOrder = 1;
    this.mesh.add(this.glow); // so that both are shown or hidden together
    this.ghosts = [false, true].map((blended) => {
      const material = new THREE.ShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader: kSurfaceVertex, fragmentShader: kSurfaceFragment, defines: { GHOST: 1 }, uniforms: this.material.uniforms, side: THREE.DoubleSide, transparent: true, colorWrite: blended, depthWrite: !blended });
      const ghost = new THREE.Mesh(geometry, material);
      ghost.frustumCulled = false;
      ghost.renderOrder = blended ? 3 : 2;
      this.mesh.add(ghost);
      return ghost;
    });
  }

  /** Something is see-through only if all is, or around a chosen contact. */
  private showGhosts(): void {
    const { seeThrough, showContact } = this.material.uniforms;
    for (const ghost of this.ghosts) ghost.visible = seeThrough!.value || showContact!.value;
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
    this.positionUniforms.posA.value = this.shown.a.texture;
    this.positionUniforms.posB.value = this.shown.b.texture;
    this.set('normalA', this.shown.a.normals);
    this.set('normalB', this.shown.b.normals);
    this.positionUniforms.blend.value = blend;
  }

  /** Whether to show what is inside at the end of the step rather than at its begin. */
  showEnd(end: boolean): void {
    this.set('insideBit', end ? 4 : 2);
  }

  /** Sets the two poses from which errors are measured. */
  reference(a: Poses, b: Poses): void {
    this.other ??= new FramePair(floatsOf(this.info.vertices), null);
    this.other.set(a.data, a.tag, b.data, b.tag);
    this.set('refA', this.other.a.texture);
    this.set('refB', this.other.b.texture);
  }

  /** Sets the data of the triangles in the current step; null if there is none (yet). */
  setFaces(data: Uint8Array<ArrayBuffer> | null, changed: boolean): void {
    this.set('hasFaces', data !== null);
    const { hasFaces, showInside, showMeets, showContact } = this.material.uniforms;
    this.glow.visible = (hasFaces!.value && (showInside!.value || showMeets!.value)) || showContact!.value;
    if (data === null || (data === this.faceSource && !changed)) return;
    this.faceSource = data;
    if (this.faces.image.height !== data.length / kRow) this.faces.dispose();
    this.faces.image = { data, width: kRow, height: data.length / kRow };
    this.faces.needsUpdate = true;
  }

  /** Sets which part of the chosen contact each triangle is (shaders.ts); null without one. */
  setContact(marks: Uint8Array | null): void {
    this.set('showContact', marks !== null);
    this.showGhosts();
    if (marks) setMarks(this.contactTexture, marks);
  }

  /** Sets which vertices are painted; null: none are shown. */
  setPainted(mask: Uint8Array | null): void {
    this.set('showPainted', mask !== null);
    if (mask) setMarks(this.paintedTexture, mask);
  }

  paint(options: { paint: Paint; collisions: boolean; meets: boolean; edges: boolean; seeThrough: boolean; errorScale: number; edgeColor: Rgb }): void {
    this.set('surface', kPaints.indexOf(options.paint === 'correction' ? 'error' : options.paint));
    this.set('showInside', options.collisions);
    this.set('showMeets', options.meets);
    this.set('edges', options.edges);
    this.set('seeThrough', options.seeThrough);
    this.showGhosts();
    this.set('errorScale', options.errorScale);
    (this.material.uniforms['edgeColor']!.value as THREE.Vector3).copy(vec3(options.edgeColor));
  }

  /** The current position of a vertex, in mesh units from the scene's center. */
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

/** The first triangle of those shown that a ray in mesh units hits. */
export function firstHit(surfaces: Surface[], ray: THREE.Ray): { object: number; face: number; point: THREE.Vector3 } | null {
  let best: { object: number; face: number; point: THREE.Vector3; distance: number } | null = null;
  surfaces.forEach((surface, object) => {
    if (!surface.mesh.visible) return;
    const hit = surface.hit(ray);
    if (hit && (!best || hit.distance < best.distance)) best = { object, ...hit };
  });
  return best;
}
