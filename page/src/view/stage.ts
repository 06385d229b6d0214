// The camera, its controls, and the picture. Draws only when something has changed.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

export type Side = 'front' | 'side' | 'top';
const kSides: Record<Side, THREE.Vector3> = {
  front: new THREE.Vector3(0, 0, 1),
  side: new THREE.Vector3(1, 0, 0),
  top: new THREE.Vector3(0, 1, 0.0001),
};
const kFlightMs = 450;

/** The framing margin as a factor; on narrow screens it keeps the content clear of the buttons over the picture. */
const framingMargin = ({ clientWidth, clientHeight }: HTMLElement): number => (clientWidth < 700 ? 1 / Math.max(0.4, 1 - 104 / Math.max(1, clientHeight)) : 1.03);

interface Flight {
  start: number;
  from: THREE.Vector3;
  fromTarget: THREE.Vector3;
  to: THREE.Vector3;
  toTarget: THREE.Vector3;
}

export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
  readonly canvas = document.createElement('canvas');
  readonly viewport: THREE.IUniform = { value: new THREE.Vector2(1, 1) };
  readonly ratio = Math.min(devicePixelRatio, 2);
  private readonly renderer: THREE.WebGLRenderer;
  private readonly controls: OrbitControls;
  private flight: Flight | null = null;
  private dirty = true;

  /** `frame` maps mesh units to those of the scene, where the first frame's box has size 2 and center 0. */
  constructor(
    readonly parent: HTMLElement,
    readonly frame: { center: THREE.Vector3; scale: number },
    private readonly bounds: () => THREE.Box3, // of what is shown, mesh units
  ) {
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('aria-label', 'The meshes: drag to orbit, right-drag or two fingers to pan, wheel or pinch to zoom');
    parent.prepend(this.canvas);
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(this.ratio);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.18;
    this.controls.zoomToCursor = true;
    this.controls.minDistance = 1e-4;
    this.controls.maxDistance = 40;
    this.controls.addEventListener('change', () => (this.dirty = true));
    this.controls.addEventListener('start', () => (this.flight = null));
    new ResizeObserver(() => this.resize()).observe(parent);
    this.resize();
    this.reset(false);
  }

  redraw(): void {
    this.dirty = true;
  }

  background(color: string): void {
    this.renderer.setClearColor(new THREE.Color(color));
    this.redraw();
  }

  /** Shows everything, slightly from above and from the side. */
  reset(animated = true): void {
    this.lookFrom(new THREE.Vector3(0.45, 0.25, 1), animated);
  }

  side(side: Side): void {
    this.lookFrom(kSides[side], true);
  }

  private lookFrom(direction: THREE.Vector3, animated: boolean): void {
    const d = direction.clone().normalize();
    const up = Math.abs(d.y) > 0.9 ? new THREE.Vector3(0, 0, -1) : new THREE.Vector3(0, 1, 0);
    const right = up.clone().cross(d).normalize();
    const above = d.clone().cross(right);
    const box = this.bounds();
    const size = box.getSize(new THREE.Vector3()).multiplyScalar(this.frame.scale);
    const half = (axis: THREE.Vector3) => (Math.abs(axis.x) * size.x + Math.abs(axis.y) * size.y + Math.abs(axis.z) * size.z) / 2;
    const tangent = Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2));
    const distance = half(d) + framingMargin(this.parent) * Math.max(half(above) / tangent, half(right) / (tangent * this.camera.aspect), 1e-3);
    const target = box.getCenter(new THREE.Vector3()).sub(this.frame.center).multiplyScalar(this.frame.scale);
    this.fly(d.multiplyScalar(distance).add(target), target, animated);
  }

  /** The direction from the target to the eye. */
  get direction(): THREE.Vector3 {
    return this.camera.position.clone().sub(this.controls.target).normalize();
  }

  /** Moves to a point in mesh units, so near that `size` fills a good part of the picture. */
  approach(point: THREE.Vector3, size: number, direction = this.direction): void {
    const target = point.clone().sub(this.frame.center).multiplyScalar(this.frame.scale);
    const distance = Math.max((5 * size * this.frame.scale) / Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2)), 1e-3);
    this.fly(target.clone().addScaledVector(direction, distance), target, true);
  }

  private fly(to: THREE.Vector3, toTarget: THREE.Vector3, animated: boolean): void {
    const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
    if (!animated || still) {
      this.flight = null;
      this.camera.position.copy(to);
      this.controls.target.copy(toTarget);
    } else {
      this.flight = { start: performance.now(), from: this.camera.position.clone(), fromTarget: this.controls.target.clone(), to, toTarget };
    }
    this.dirty = true;
  }

  orbit(right: number, up: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const spherical = new THREE.Spherical().setFromVector3(offset);
    spherical.theta -= right;
    spherical.phi = Math.min(Math.max(spherical.phi - up, 0.01), Math.PI - 0.01);
    this.camera.position.setFromSpherical(spherical).add(this.controls.target);
    this.dirty = true;
  }

  zoom(factor: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
    this.camera.position.copy(this.controls.target).add(offset);
    this.dirty = true;
  }

  /** The ray under a point of the window, in mesh units. */
  ray(x: number, y: number): THREE.Ray {
    const box = this.canvas.getBoundingClientRect();
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2), this.camera);
    const { origin, direction } = caster.ray;
    return new THREE.Ray(origin.clone().divideScalar(this.frame.scale).add(this.frame.center), direction.clone());
  }

  /** Draws if something has changed; true if it did. */
  draw(now: number): boolean {
    if (this.flight) {
      const { start, from, fromTarget, to, toTarget } = this.flight;
      const s = Math.min(1, (now - start) / kFlightMs);
      const eased = s * s * (3 - 2 * s);
      this.camera.position.lerpVectors(from, to, Math.max(0, eased));
      this.controls.target.lerpVectors(fromTarget, toTarget, Math.max(0, eased));
      if (s >= 1) this.flight = null;
      this.dirty = true;
    }
    this.controls.update();
    if (!this.dirty) return false;
    this.dirty = false;
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(distance * 0.02, 1e-5);
    this.camera.far = distance + 20;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
    return true;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.parent;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    (this.viewport.value as THREE.Vector2).set(width, height);
    this.camera.aspect = width / height;
    this.dirty = true;
    this.draw(performance.now()); // At once, as resizing clears the canvas.
  }
}
