// The picture: what is in it, when it is drawn, and pictures of it. Draws only when something has changed.
import * as THREE from 'three';
import { Camera } from './camera';
import { Gizmo } from './gizmo';
import { Ground } from './ground';
import type { FocusUniforms } from './surface';

const kOverview = 0.24; // of the shorter side of the picture

/** The chosen contact, in the scene. */
export interface Focus {
  point: THREE.Vector3;
  radius: number;
  sides: [THREE.Vector3, THREE.Vector3]; // the middle of each
}

export class Stage {
  readonly scene = new THREE.Scene();
  readonly canvas = document.createElement('canvas');
  readonly camera: Camera;
  readonly ground = new Ground();
  readonly gizmo: Gizmo;
  readonly viewport: THREE.IUniform = { value: new THREE.Vector2(1, 1) };
  readonly ratio = Math.min(devicePixelRatio, 2);
  readonly focusUniforms: FocusUniforms = { focus: { value: new THREE.Vector4() }, nearSide: { value: 0 }, clip: { value: new THREE.Vector4(0, 0, 0, 1) } };
  focus: Focus | null = null;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly wide = new THREE.PerspectiveCamera(32, 1, 0.01, 200);
  private readonly marker = new THREE.Mesh(new THREE.SphereGeometry(1, 16, 12), new THREE.MeshBasicMaterial({ color: 0xd52c00, depthTest: false, transparent: true }));
  private dirty = true;

  /** Positions in mesh units from the scene's center are multiplied by `scale`: the first frame's box has size 2. */
  constructor(
    readonly parent: HTMLElement,
    readonly scale: number,
    bounds: () => THREE.Box3, // of the motion, in the scene
    private readonly poseBounds: () => THREE.Box3, // of what is shown of it
  ) {
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('aria-label', 'The meshes: drag to orbit, right-drag or two fingers to pan, wheel or pinch to zoom');
    parent.prepend(this.canvas);
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(this.ratio);
    this.renderer.autoClear = false;
    this.camera = new Camera(this.canvas, parent, bounds, () => (this.dirty = true));
    this.gizmo = new Gizmo((side) => this.camera.side(side), () => this.camera.up);
    this.marker.renderOrder = 10;
    this.marker.visible = false;
    this.scene.add(this.ground.grid, this.marker);
    new ResizeObserver(() => this.resize()).observe(parent);
    this.resize();
  }

  redraw(): void {
    this.dirty = true;
  }

  background(color: string, grid: string): void {
    this.renderer.setClearColor(new THREE.Color(color));
    this.ground.color(grid);
    this.redraw();
  }

  /** The ray under a point of the window, in mesh units from the scene's center. */
  ray(x: number, y: number): THREE.Ray {
    const box = this.canvas.getBoundingClientRect();
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2), this.camera.eye);
    const { origin, direction } = caster.ray;
    return new THREE.Ray(origin.clone().divideScalar(this.scale), direction.clone());
  }

  /** The size of a pixel at a point; both in mesh units, the point from the scene's center. */
  pixelAt(point: THREE.Vector3): number {
    const { eye } = this.camera;
    const depth = -point.clone().multiplyScalar(this.scale).applyMatrix4(eye.matrixWorldInverse).z;
    return (2 * depth * Math.tan(THREE.MathUtils.degToRad(eye.fov / 2))) / (this.canvas.clientHeight * this.scale);
  }

  /** Draws if something has changed; true if it did. */
  draw(now: number): boolean {
    if (this.camera.update(now)) this.dirty = true;
    if (!this.dirty) return false;
    this.dirty = false;
    this.render();
    return true;
  }

  private render(): void {
    const { eye } = this.camera;
    this.camera.fitDepth();
    eye.updateMatrixWorld();
    this.setFocus(eye);
    this.renderer.clear();
    this.renderer.render(this.scene, eye);
    this.gizmo.show(eye);
    if (this.focus) this.renderOverview(this.focus);
  }

  private setFocus(eye: THREE.Camera | null): void {
    const { focus, nearSide } = this.focusUniforms;
    if (!this.focus || !eye) {
      focus.value.w = 0;
      nearSide.value = 0;
      return;
    }
    const at = this.focus.point.clone().applyMatrix4(eye.matrixWorldInverse);
    focus.value.set(at.x, at.y, at.z, 1.6 * this.focus.radius);
    const [a, b] = this.focus.sides.map((side) => side.clone().applyMatrix4(eye.matrixWorldInverse).z);
    nearSide.value = a! > b! ? 1 : 2;
  }

  /** The pose, small in a corner, with a dot at the chosen contact. */
  private renderOverview({ point }: Focus): void {
    const { wide, renderer } = this;
    const { clientWidth: width, clientHeight: height } = this.parent;
    const size = Math.round(kOverview * Math.min(width, height));
    const sphere = this.poseBounds().getBoundingSphere(new THREE.Sphere());
    const distance = (1.05 * sphere.radius) / Math.sin(THREE.MathUtils.degToRad(wide.fov / 2));
    wide.up.copy(this.camera.up);
    wide.position.copy(sphere.center).addScaledVector(this.camera.direction, distance);
    wide.lookAt(sphere.center);
    wide.near = 0.01 * distance;
    wide.far = 3 * distance;
    wide.updateProjectionMatrix();
    wide.updateMatrixWorld();
    this.setFocus(null);
    this.marker.position.copy(point);
    this.marker.scale.setScalar(0.05 * sphere.radius);
    this.marker.visible = true;
    // Top right; on a narrow picture the buttons are there, so bottom left.
    const [left, bottom] = width < 700 ? [10, 10] : [width - size - 10, height - size - 10];
    renderer.setViewport(left, bottom, size, size);
    renderer.setScissor(left, bottom, size, size);
    renderer.setScissorTest(true);
    renderer.clear();
    renderer.render(this.scene, wide);
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, width, height);
    this.marker.visible = false;
  }

  /** A small picture of the scene as it is, from where the camera is; the picture on the page stays. */
  thumbnail(width: number, height: number): ImageData {
    const { eye } = this.camera;
    const target = new THREE.WebGLRenderTarget(width, height);
    const ground = this.renderer.getClearColor(new THREE.Color());
    const wide = this.wide;
    const sphere = this.poseBounds().getBoundingSphere(new THREE.Sphere());
    wide.copy(eye);
    if (this.focus === null) {
      wide.position.copy(sphere.center).addScaledVector(this.camera.direction, sphere.radius / Math.sin(THREE.MathUtils.degToRad(wide.fov / 2)));
    }
    wide.aspect = width / height;
    wide.updateProjectionMatrix();
    wide.updateMatrixWorld();
    this.renderer.setRenderTarget(target);
    this.renderer.setClearColor(ground.clone().convertLinearToSRGB()); // what a target gets is not converted
    this.renderer.clear();
    this.renderer.render(this.scene, wide);
    const pixels = new Uint8ClampedArray(4 * width * height);
    this.renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    this.renderer.setRenderTarget(null);
    this.renderer.setClearColor(ground);
    target.dispose();
    const image = new ImageData(width, height);
    for (let y = 0; y < height; ++y) image.data.set(pixels.subarray(4 * width * (height - 1 - y), 4 * width * (height - y)), 4 * width * y);
    return image;
  }

  /** The picture as PNG. */
  png(): Promise<Blob | null> {
    this.render(); // The canvas keeps its content only until the browser shows it.
    return new Promise((done) => this.canvas.toBlob(done, 'image/png'));
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.parent;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    (this.viewport.value as THREE.Vector2).set(width, height);
    this.camera.eye.aspect = width / height;
    this.dirty = true;
    this.draw(performance.now()); // At once, as resizing clears the canvas.
  }
}
