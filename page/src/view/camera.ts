// The camera: a turntable around an upright axis, flights, views from six sides, and what it follows.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { defaultDirection, upright, type Up, type Vector } from '../shared/upright';

export type Side = 'front' | 'back' | 'right' | 'left' | 'top' | 'bottom';
/** With y up. From straight above, the front is below. */
const kSides: Record<Side, Vector> = { front: [0, 0, 1], back: [0, 0, -1], right: [1, 0, 0], left: [-1, 0, 0], top: [0, 1, 1e-4], bottom: [0, -1, 1e-4] };
const kFlightMs = 450;

/** The framing margin as a factor; on narrow screens it keeps the content clear of the buttons over the picture. */
const framingMargin = ({ clientWidth, clientHeight }: HTMLElement): number => (clientWidth < 700 ? 1 / Math.max(0.55, 1 - 104 / Math.max(1, clientHeight)) : 1.06);

interface Flight {
  start: number;
  from: THREE.Vector3;
  fromTarget: THREE.Vector3;
  to: THREE.Vector3;
  toTarget: THREE.Vector3;
}

/** All positions are those of the scene. */
export class Camera {
  readonly eye = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
  readonly up = new THREE.Vector3(0, 1, 0);
  axis: Up = 'y';
  /** Whether the user has moved the camera since it last showed everything. */
  moved = false;
  private controls!: OrbitControls;
  private flight: Flight | null = null;

  constructor(
    private readonly canvas: HTMLElement,
    private readonly parent: HTMLElement,
    private readonly bounds: () => THREE.Box3, // of what is shown
    private readonly changed: () => void,
  ) {
    this.setUp('y');
  }

  /** Turns the upright axis; call showAll() then. */
  setUp(up: Up): void {
    this.axis = up;
    this.up.copy(this.turned([0, 1, 0]));
    this.eye.up.copy(this.up);
    const target = this.controls?.target ?? new THREE.Vector3();
    this.controls?.dispose();
    this.controls = new OrbitControls(this.eye, this.canvas); // reads the upright axis only once
    this.controls.target.copy(target);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.18;
    this.controls.zoomToCursor = true;
    this.controls.minDistance = 1e-4;
    this.controls.maxDistance = 60;
    this.controls.addEventListener('change', this.changed);
    this.controls.addEventListener('start', () => {
      this.flight = null;
      this.moved = true;
    });
  }

  get target(): THREE.Vector3 {
    return this.controls.target;
  }

  /** A direction of a scene with y up. */
  private turned(direction: Vector): THREE.Vector3 {
    return new THREE.Vector3(...upright(direction, this.axis));
  }

  /** Shows everything, slightly from above and from the side. */
  showAll(animated = true): void {
    this.lookFrom(new THREE.Vector3(...defaultDirection(this.axis)), animated);
    this.moved = false;
  }

  side(side: Side): void {
    this.lookFrom(this.turned(kSides[side]), true);
    this.moved = true;
  }

  private lookFrom(direction: THREE.Vector3, animated: boolean): void {
    const d = direction.clone().normalize();
    const right = this.up.clone().cross(d).normalize();
    const above = d.clone().cross(right);
    const box = this.bounds();
    const size = box.getSize(new THREE.Vector3());
    const half = (axis: THREE.Vector3) => (Math.abs(axis.x) * size.x + Math.abs(axis.y) * size.y + Math.abs(axis.z) * size.z) / 2;
    const distance = half(d) + framingMargin(this.parent) * Math.max(half(above) / this.tangent, half(right) / (this.tangent * this.eye.aspect), 1e-3);
    const target = box.getCenter(new THREE.Vector3());
    this.fly(d.multiplyScalar(distance).add(target), target, animated);
  }

  private get tangent(): number {
    return Math.tan(THREE.MathUtils.degToRad(this.eye.fov / 2));
  }

  /** The direction from the target to the eye. */
  get direction(): THREE.Vector3 {
    return this.eye.position.clone().sub(this.target).normalize();
  }

  /** Moves so near to a point that `size` fills a good part of the picture. */
  approach(target: THREE.Vector3, size: number, direction = this.direction): void {
    const narrow = Math.min(1, this.eye.aspect);
    const distance = Math.max(size / (this.tangent * narrow), 1e-3);
    this.fly(target.clone().addScaledVector(direction, distance), target, true);
    this.moved = true;
  }

  private fly(to: THREE.Vector3, toTarget: THREE.Vector3, animated: boolean): void {
    const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
    if (!animated || still) {
      this.flight = null;
      this.eye.position.copy(to);
      this.target.copy(toTarget);
    } else {
      this.flight = { start: performance.now(), from: this.eye.position.clone(), fromTarget: this.target.clone(), to, toTarget };
    }
    this.changed();
  }

  /** Places the camera as it was. */
  place(position: THREE.Vector3, target: THREE.Vector3): void {
    this.fly(position, target, false);
    this.moved = true;
  }

  /** Moves along with what is shown. */
  shift(by: THREE.Vector3): void {
    this.eye.position.add(by);
    this.target.add(by);
    if (this.flight) for (const point of [this.flight.from, this.flight.fromTarget, this.flight.to, this.flight.toTarget]) point.add(by);
    this.changed();
  }

  orbit(right: number, up: number): void {
    const upright = new THREE.Quaternion().setFromUnitVectors(this.up, new THREE.Vector3(0, 1, 0));
    const offset = this.eye.position.clone().sub(this.target).applyQuaternion(upright);
    const spherical = new THREE.Spherical().setFromVector3(offset);
    spherical.theta -= right;
    spherical.phi = Math.min(Math.max(spherical.phi - up, 0.01), Math.PI - 0.01);
    this.eye.position.setFromSpherical(spherical).applyQuaternion(upright.invert()).add(this.target);
    this.moved = true;
    this.changed();
  }

  zoom(factor: number): void {
    const offset = this.eye.position.clone().sub(this.target).multiplyScalar(factor);
    this.eye.position.copy(this.target).add(offset);
    this.moved = true;
    this.changed();
  }

  /** Call it before each picture; true while it moves by itself. */
  update(now: number): boolean {
    const { flight } = this;
    if (flight) {
      const s = Math.min(1, Math.max(0, (now - flight.start) / kFlightMs));
      const eased = s * s * (3 - 2 * s);
      this.eye.position.lerpVectors(flight.from, flight.to, eased);
      this.target.lerpVectors(flight.fromTarget, flight.toTarget, eased);
      if (s >= 1) this.flight = null;
    }
    this.controls.update();
    return flight !== null;
  }

  /** Sets the near and far planes. */
  fitDepth(): void {
    const distance = this.eye.position.distanceTo(this.target);
    this.eye.near = Math.max(distance * 0.02, 1e-5);
    this.eye.far = distance + 60;
    this.eye.updateProjectionMatrix();
  }
}
