// Finds a direction from which a contact is visible: it usually lies between two parts of a surface.
import * as THREE from 'three';
import type { Surface } from './surface';

const kDirections = 64;

/** Directions evenly distributed over the sphere (a Fibonacci lattice). */
function lattice(): THREE.Vector3[] {
  const golden = Math.PI * (3 - Math.sqrt(5));
  return Array.from({ length: kDirections }, (_, k) => {
    const y = 1 - (2 * k + 1) / kDirections;
    const r = Math.sqrt(1 - y * y);
    return new THREE.Vector3(r * Math.cos(golden * k), y, r * Math.sin(golden * k));
  });
}

/**
 * The direction nearest to `preferred` from which nothing farther than `minDistance` hides the point; `preferred` if there is
 * none. Directions from nearly straight above or below are excluded: there the camera would roll.
 */
export function clearDirection(surfaces: Surface[], point: THREE.Vector3, minDistance: number, preferred: THREE.Vector3, up: THREE.Vector3): THREE.Vector3 {
  const candidates = [preferred, ...lattice().filter((d) => Math.abs(d.dot(up)) < 0.95).sort((a, b) => b.dot(preferred) - a.dot(preferred))];
  const shown = surfaces.filter((surface) => surface.mesh.visible);
  return candidates.find((d) => !shown.some((surface) => surface.blocks(new THREE.Ray(point, d), minDistance))) ?? preferred;
}
