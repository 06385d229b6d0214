// Meshes and their frames, as the engine takes them.
import type { Engine } from './engine.js';
import { Memory, flat, succeed, wellFormed } from './memory.js';
import { FoldproofError, type Mesh, type Motion, type Rows } from './types.js';

/** The names of parts, each one once, and the part of each triangle. */
function partsOf(parts: ArrayLike<string>, triangles: number, where: string): { names: string[]; ofTriangle: Uint32Array } {
  if (parts.length !== triangles) throw new FoldproofError(`${where}.parts`, `has ${parts.length} names for ${triangles} triangles`, 'give one for each triangle');
  const ids = new Map<string, number>();
  const ofTriangle = new Uint32Array(triangles);
  for (let k = 0; k < triangles; ++k) {
    const name = wellFormed(String(parts[k]));
    if (!ids.has(name)) ids.set(name, ids.size);
    ofTriangle[k] = ids.get(name)!;
  }
  return { names: [...ids.keys()], ofTriangle };
}

/** Throws a TypeError for what is no object. */
export function requireObject(value: unknown, where: string, members: string): void {
  if (typeof value !== 'object' || value === null) throw new TypeError(`${where}: expected an object with ${members}, not ${String(value)}`);
}

/** Motions or meshes that are gathered in the engine; `drop` ends them. */
export class Meshes {
  readonly handle: number;
  readonly vertexCounts: number[] = [];

  constructor(private readonly engine: Engine) {
    this.handle = engine._foldproof_meshes();
  }

  drop(): void {
    this.engine._foldproof_drop_meshes(this.handle);
  }

  /** Adds a mesh; its number of frames. */
  async add(motion: Motion, where: string): Promise<number> {
    requireObject(motion, where, 'faces and frames');
    const { faces, frames, name, parts } = motion;
    let count = 0;
    if (typeof frames !== 'object' || frames === null) throw new FoldproofError(`${where}.frames`, 'is missing', 'give the positions of every frame');
    for await (const rows of frames) {
      if (count === 0) this.start({ faces, positions: rows }, where, name ?? where, parts);
      this.frame(rows, `${where}.frames[${count}]`);
      ++count;
    }
    if (count === 0) throw new FoldproofError(`${where}.frames`, 'is empty', 'give the positions of every frame');
    return count;
  }

  /** Adds a mesh without a frame. */
  start({ faces, positions }: Mesh, where: string, name = where, parts?: ArrayLike<string>): void {
    const { engine } = this;
    const memory = new Memory(engine);
    try {
      const ids = flat(faces, `${where}.faces`);
      const vertices = flat(positions, `${where}, first positions`).length / 3;
      const named = parts && partsOf(parts, ids.length / 3, where);
      const status = engine._foldproof_add_mesh(this.handle, memory.text(name), memory.ids(ids, `${where}.faces`), ids.length / 3, vertices, memory.text(JSON.stringify(named?.names ?? [])), named ? memory.ids(named.ofTriangle, where) : 0);
      succeed(engine, status);
      this.vertexCounts.push(vertices);
    } finally {
      memory.free();
    }
  }

  /** Adds a frame of the last mesh. */
  frame(rows: Rows, where: string): void {
    const memory = new Memory(this.engine);
    try {
      const at = memory.numbers(sized(rows, this.vertexCounts.at(-1)!, where));
      succeed(this.engine, this.engine._foldproof_add_frame(this.handle, at));
    } finally {
      memory.free();
    }
  }
}

/** Positions of this many vertices. */
export function sized(rows: Rows, vertices: number, where: string): ArrayLike<number> {
  const values = flat(rows, where);
  if (values.length !== 3 * vertices) throw new FoldproofError(where, `has ${values.length / 3} vertices instead of ${vertices}`, 'give the positions of all vertices');
  return values;
}
