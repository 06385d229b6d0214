// The chosen contact in the picture: its two sides, the region inside, and the curve in which the surfaces cross.
import * as THREE from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { directionAlong } from '../shared/upright';
import type { Contact } from '../shared/contact';
import type { Stage } from './stage';
import type { Surface } from './surface';

const kCurveFrames = 0.26; // The curve is that of the worst frame, and shown only near it.

export class ContactView {
  readonly group = new THREE.Group();
  private contact: Contact | null = null;
  private marked: Contact[] = []; // whose sides are colored

  constructor(
    private readonly stage: Stage,
    private readonly surfaces: Surface[],
    private readonly center: THREE.Vector3, // mesh units
  ) {
    this.group.visible = false;
  }

  /** A point in mesh units as one of the scene. */
  private toScene(point: readonly number[]): THREE.Vector3 {
    return new THREE.Vector3(...(point as [number, number, number])).sub(this.center).multiplyScalar(this.stage.scale);
  }

  /** The one that is chosen. */
  get chosen(): Contact | null {
    return this.contact;
  }

  set(contact: Contact | null): void {
    this.contact = contact;
    this.group.visible = false; // until it is shown where it is
    this.setMarks(contact ? [contact] : []);
    for (const line of this.group.children as LineSegments2[]) {
      line.geometry.dispose();
      line.material.dispose();
    }
    this.group.clear();
    if (contact) this.addCurves(contact);
    this.stage.focus = null;
  }

  /** Colors the two sides of these and no others. */
  mark(contacts: Contact[]): void {
    if (contacts.length !== this.marked.length || contacts.some((contact, k) => contact !== this.marked[k])) this.setMarks(contacts);
  }

  private setMarks(contacts: Contact[]): void {
    this.marked = contacts;
    this.surfaces.forEach((surface, i) => surface.setContact(contacts.length > 0 ? this.marksOf(contacts, i) : null));
  }

  /** Per triangle: 1 and 2 the first side, crossing and inside; 3 and 4 the second. */
  private marksOf(contacts: Contact[], object: number): Uint8Array {
    const marks = new Uint8Array(this.surfaces[object]!.info.triangles);
    for (const { sides } of contacts) {
      sides.forEach((side, k) => {
        if (side.object !== object) return;
        for (const face of side.triangles ?? []) marks[face] = 1 + 2 * k;
        for (const face of side.inside ?? []) marks[face] = 2 + 2 * k;
      });
    }
    return marks;
  }

  private addCurves({ curves }: Contact): void {
    const points: number[] = [];
    for (const curve of curves ?? []) {
      for (let k = 0; k + 1 < curve.length; ++k) points.push(...this.toScene(curve[k]!).toArray(), ...this.toScene(curve[k + 1]!).toArray());
    }
    if (points.length === 0) return;
    // White with a dark rim is seen on every color.
    for (const [color, width, order] of [[0x14191d, 3.6, 8], [0xffffff, 1.6, 9]] as const) {
      const material = new LineMaterial({ color, linewidth: width, depthTest: false, transparent: true });
      const line = new LineSegments2(new LineSegmentsGeometry().setPositions(points), material);
      line.frustumCulled = false;
      line.renderOrder = order;
      this.group.add(line);
    }
  }

  /** The middle of a side where it is now. */
  private middleOf(side: Contact['sides'][number]): THREE.Vector3 | null {
    const surface = this.surfaces[side.object]!;
    const faces = side.triangles ?? [];
    if (faces.length === 0) return null;
    const sum = new THREE.Vector3();
    const at = new THREE.Vector3();
    for (const face of faces) sum.add(surface.vertex(surface.triangles[3 * face]!, at));
    return sum.divideScalar(faces.length).multiplyScalar(this.stage.scale);
  }

  /** Half of the diagonal of its box, in the scene. */
  get radius(): number {
    const [low, high] = this.contact!.box;
    return Math.max(this.toScene(low).distanceTo(this.toScene(high)) / 2, 1e-3);
  }

  /** Where it is now: it moves with the surfaces. */
  get place(): THREE.Vector3 {
    const { sides, point } = this.contact!;
    const middles = sides.map((side) => this.middleOf(side)).filter((middle) => middle !== null);
    if (middles.length === 0) return this.toScene(point);
    return middles.reduce((sum, middle) => sum.add(middle), new THREE.Vector3()).divideScalar(middles.length);
  }

  /** Looks at a position of the timeline; `worst` is that of the contact. */
  show(visible: boolean, position: number, worst: number): void {
    const { contact, stage } = this;
    this.group.visible = visible && Math.abs(position - worst) < kCurveFrames;
    if (!visible || !contact) {
      stage.focus = null;
      return;
    }
    const place = this.place;
    const [a, b] = contact.sides.map((side) => this.middleOf(side) ?? place);
    stage.focus = { point: place, radius: this.radius, sides: [a!, b!] };
  }

  /** The direction to look from: the program's, from which both sides and the curve are seen. */
  direction(): THREE.Vector3 | null {
    const { view } = this.contact!;
    return view ? new THREE.Vector3(...directionAlong(view, this.stage.camera.axis)).normalize() : null;
  }
}
