// Which of the dropped files are motions, in the order in which the engine takes them.

const kMeshes = ['.obj', '.off', '.ply', '.stl', '.vtk', '.msh'];
const kCaches = ['.pc2', '.mdd'];
const kAnimations = ['.glb', '.gltf', '.npz'];
const kModels = ['.model'];
export const kReadable = [...kMeshes, ...kCaches, ...kAnimations, '.npy', ...kModels];

export interface Arguments {
  files: string[];
  models: string[];
}

const extensionOf = (path: string): string => /\.[^./]+$/.exec(path)?.[0].toLowerCase() ?? '';
const is = (kind: string[]) => (path: string): boolean => kind.includes(extensionOf(path));
const stemOf = (path: string): string => path.slice(0, path.length - extensionOf(path).length);
const folderOf = (path: string): string => path.slice(0, Math.max(0, path.lastIndexOf('/')));
const natural = new Intl.Collator('en', { numeric: true });

/** Meshes and caches of one folder: each cache follows the mesh of its name, or the only one where one of each is left. */
function meshesOf(folder: string, paths: string[]): string[] {
  const meshes = paths.filter(is(kMeshes));
  const caches = paths.filter(is(kCaches));
  if (folder !== '' && meshes.length > 1 && caches.length === 0) return [folder]; // frames
  const left = [...meshes];
  const files: string[] = [];
  const unnamed: string[] = [];
  for (const cache of caches) {
    const named = left.findIndex((mesh) => stemOf(mesh) === stemOf(cache));
    if (named < 0) unnamed.push(cache);
    else files.push(...left.splice(named, 1), cache);
  }
  if (left.length === 1 && unnamed.length === 1) return [...files, ...left, ...unnamed];
  return [...files, ...unnamed, ...left]; // the engine says what is missing of a cache without a mesh
}

export function argumentsOf(paths: string[]): Arguments {
  const sorted = [...paths].sort(natural.compare);
  const files: string[] = [];
  for (const folder of new Set(sorted.map(folderOf))) {
    const here = sorted.filter((path) => folderOf(path) === folder);
    files.push(...here.filter(is(kAnimations)), ...here.filter(is(['.npy'])), ...meshesOf(folder, here));
  }
  return { files, models: sorted.filter(is(kModels)) };
}
