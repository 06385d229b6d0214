// From where a contact can be seen: it usually lies between two parts of a surface.
import * as THREE from 'three';
import type { Surface } from './surface';

const kDirections = 64;

/** Evenly spread over the sphere (a Fibonacci lattice). */
function lattice(): THREE.Vector3[] {
  const golden = Math.PI * (3 - Math.sqrt(5));
  return Array.from({ length: kDirections }, (_, k) => {
    const y = 1 - (2 * k + 1) / kDirections;
    const r = Math.sqrt(1 - y * y);
    return new THREE.Vector3(r * Math.cos(golden * k), y, r * Math.sin(golden * k));
  });
}

/**
 * The direction nearest to `wish` in which nothing beyond `least` hides the point; `wish` when there is none. Nearly straight
 * from above and below are left out: there the camera would roll.
 */
export function clearDirection(surfaces: Surface[], point: THREE.Vector3, least: number, wish: THREE.Vector3): THREE.Vector3 {
  const candidates = [wish, ...lattice().filter((d) => Math.abs(d.y) < 0.95).sort((a, b) => b.dot(wish) - a.dot(wish))];
  const shown = surfaces.filter((surface) => surface.mesh.visible);
  return candidates.find((d) => !shown.some((surface) => surface.blocks(new THREE.Ray(point, d), least))) ?? wish;
}
