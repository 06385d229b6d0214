// A skinned tube that bends until its ends meet. Triangles that touch something on the way from one picture to the next are red.
import * as THREE from 'three';
import { StepChecker } from 'foldproof';

const kBones = 12;
const kLength = 12;
const kCalm = new THREE.Color(0x8aa4c8);
const kColliding = new THREE.Color(0xe02020);

/** Generated: a tube along y, with a bone for each unit of its length. */
function makeTube() {
  const geometry = new THREE.CylinderGeometry(0.6, 0.6, kLength, 24, 8 * kBones, true);
  const place = geometry.attributes.position;
  const ids = [];
  const weights = [];
  for (let v = 0; v < place.count; ++v) {
    const along = Math.min(((place.getY(v) + kLength / 2) / kLength) * kBones, kBones - 1e-6);
    ids.push(Math.floor(along), Math.min(Math.floor(along) + 1, kBones), 0, 0);
    weights.push(1 - (along % 1), along % 1, 0, 0);
  }
  geometry.setAttribute('skinIndex', new THREE.Uint16BufferAttribute(ids, 4));
  geometry.setAttribute('skinWeight', new THREE.Float32BufferAttribute(weights, 4));
  geometry.setAttribute('color', new THREE.Float32BufferAttribute(new Float32Array(3 * place.count), 3));
  const bones = Array.from({ length: kBones + 1 }, (_, k) => {
    const bone = new THREE.Bone();
    bone.position.y = k === 0 ? -kLength / 2 : kLength / kBones;
    return bone;
  });
  for (let k = 0; k < kBones; ++k) bones[k].add(bones[k + 1]);
  const mesh = new THREE.SkinnedMesh(geometry, new THREE.MeshStandardMaterial({ vertexColors: true, side: THREE.DoubleSide }));
  mesh.add(bones[0]);
  mesh.bind(new THREE.Skeleton(bones));
  return mesh;
}

/** A mesh whose vertices have one id for each place: loaders and generators double them at seams, and doubled vertices touch. */
function weld(geometry) {
  const ids = new Map();
  const place = geometry.attributes.position;
  const idOf = Array.from({ length: place.count }, (_, v) => {
    const key = [place.getX(v), place.getY(v), place.getZ(v)].map((x) => Math.round(1e5 * x)).join();
    if (!ids.has(key)) ids.set(key, v);
    return ids.get(key);
  });
  return Array.from(geometry.index.array, (v) => idOf[v]);
}

/** Where the skinned vertices are now. */
function positionsOf(mesh) {
  const { count } = mesh.geometry.attributes.position;
  const all = new Float64Array(3 * count);
  const point = new THREE.Vector3();
  for (let v = 0; v < count; ++v) mesh.getVertexPosition(v, point).toArray(all, 3 * v);
  return all;
}

function paint(mesh, faces, collides) {
  const color = mesh.geometry.attributes.color;
  for (let v = 0; v < color.count; ++v) color.setXYZ(v, kCalm.r, kCalm.g, kCalm.b);
  mesh.geometry.index.array.forEach((v, k) => collides[Math.floor(k / 3)] && color.setXYZ(v, kColliding.r, kColliding.g, kColliding.b));
  color.needsUpdate = true;
}

function bend(mesh, seconds) {
  const angle = (1.15 * Math.PI * (1 - Math.cos(seconds))) / kBones;
  for (const bone of mesh.skeleton.bones.slice(1)) bone.rotation.z = angle;
  mesh.skeleton.bones[0].rotation.z = (-angle * kBones) / 2;
  mesh.updateMatrixWorld(true);
}

const renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(45, 1, 0.1, 100);
camera.position.set(0, 4, 20);
camera.lookAt(0, 0, 0);
scene.add(new THREE.HemisphereLight(0xffffff, 0x667788, 2.5), new THREE.DirectionalLight(0xffffff, 1.5));
const mesh = makeTube();
scene.add(mesh);

const output = document.querySelector('output');
const faces = weld(mesh.geometry);
bend(mesh, 0);
let before = positionsOf(mesh);
const box = new THREE.Box3();
const checker = await StepChecker.create({ faces, positions: before });

function fit() {
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}
addEventListener('resize', fit);
fit();

renderer.setAnimationLoop((milliseconds) => {
  bend(mesh, milliseconds / 2000);
  const now = positionsOf(mesh);
  const step = checker.check(before, now);
  const [collides] = step.collidingFaces;
  const inside = checker.checkStatic(now).collidingFaces[0];
  paint(mesh, faces, collides.map((touches, k) => touches || inside[k]));
  const pairs = step.vertexFaceCount + step.edgeEdgeCount;
  output.textContent = pairs > 0 ? `${pairs} pairs of vertices, edges and faces collide` : 'Nothing collides';
  before = now;
  box.setFromArray(now).getCenter(mesh.position).negate();
  renderer.render(scene, camera);
});
