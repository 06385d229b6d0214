// The ground: a grid below the motion, so that up and down are seen.
import * as THREE from 'three';

const kCells = 20;

export class Ground {
  readonly grid = new THREE.GridHelper(1, kCells);

  constructor() {
    const material = this.grid.material;
    material.transparent = true;
    material.opacity = 0.55;
    material.depthWrite = false;
    material.vertexColors = false;
    this.grid.renderOrder = -1;
  }

  /** Puts it below a box of the scene. */
  place(box: THREE.Box3, up: THREE.Vector3): void {
    const size = box.getSize(new THREE.Vector3());
    const across = Math.max(size.x, size.y, size.z, 1e-6);
    // Cells of a round size: 1, 2 or 5 times a power of ten.
    const power = 10 ** Math.floor(Math.log10(across / 5));
    const cell = [1, 2, 5, 10].map((f) => f * power).find((c) => c >= across / 10) ?? power;
    this.grid.scale.setScalar(kCells * cell);
    this.grid.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), up);
    const center = box.getCenter(new THREE.Vector3());
    const below = box.min.dot(up) - center.dot(up);
    this.grid.position.copy(center).addScaledVector(up, below - 1e-3 * across);
  }

  color(color: string): void {
    this.grid.material.color.set(color);
  }
}
