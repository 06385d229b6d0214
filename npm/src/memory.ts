// What goes into the engine's memory, and what comes out of it.
import type { Engine } from './engine.js';
import { FoldproofError, type Rows } from './types.js';

const notEnough = () => new FoldproofError('memory', 'is not enough', 'check fewer frames or a part of the mesh at a time');

/** Rows of three numbers as numbers one after the other. `where` is for messages. */
export function flat(rows: Rows, where: string): ArrayLike<number> {
  if (typeof rows !== 'object' || rows === null || typeof rows.length !== 'number') throw new FoldproofError(where, 'is not an array', 'give three numbers for each row');
  if (rows.length === 0 || typeof rows[0] === 'number') {
    if (rows.length % 3 !== 0) throw new FoldproofError(where, `has ${rows.length} numbers, which three do not divide`, 'give three numbers for each row');
    return rows as ArrayLike<number>;
  }
  const all = new Float64Array(3 * rows.length);
  for (let row = 0; row < rows.length; ++row) {
    const numbers = rows[row] as ArrayLike<number>;
    if (numbers?.length !== 3) throw new FoldproofError(`${where}[${row}]`, 'is not an array of three numbers', 'give three numbers for each row');
    all.set(numbers, 3 * row);
  }
  return all;
}

/** With replacement characters for halves of surrogate pairs, which UTF-8 does not have. */
export const wellFormed = (text: string): string => text.replace(/\p{Surrogate}/gu, '\ufffd');

/** Memory of the engine that ends with `free`. */
export class Memory {
  private readonly blocks: number[] = [];

  constructor(private readonly engine: Engine) {}

  bytes(count: number): number {
    const at = this.engine._malloc(Math.max(count, 1));
    if (at === 0) throw notEnough();
    this.blocks.push(at);
    return at;
  }

  text(given: string): number {
    const text = wellFormed(given);
    const bytes = this.engine.lengthBytesUTF8(text) + 1;
    const at = this.bytes(bytes);
    this.engine.stringToUTF8(text, at, bytes);
    return at;
  }

  ids(values: ArrayLike<number>, where: string): number {
    const at = this.bytes(4 * values.length);
    for (let k = 0; k < values.length; ++k) {
      const id = values[k]!;
      if (!Number.isInteger(id) || id < 0 || id > 0xffffffff) throw new FoldproofError(`${where}[${Math.floor(k / 3)}]`, `${id} is not the id of a vertex`, 'give whole numbers from 0 on');
      this.engine.HEAPU32[at / 4 + k] = id;
    }
    return at;
  }

  numbers(values: ArrayLike<number>): number {
    const at = this.bytes(8 * values.length);
    this.engine.HEAPF64.set(values, at / 8);
    return at;
  }

  free(): void {
    for (const at of this.blocks.splice(0)) this.engine._free(at);
  }
}

const kTypes = { Uint8Array, Uint32Array, Float64Array };
interface Place {
  array: keyof typeof kTypes;
  at: number;
  length: number;
}
const isPlace = (value: unknown): value is Place => typeof value === 'object' && value !== null && 'array' in value;

/** The answer of the last call. */
export function answerOf(engine: Engine): unknown {
  const text = engine.UTF8ToString(engine._foldproof_answer());
  const begin = engine._foldproof_arrays();
  return JSON.parse(text, (_, value: unknown) => {
    if (!isPlace(value)) return value;
    const type = kTypes[value.array];
    const at = begin + value.at;
    return new type(engine.HEAPU8.slice(at, at + value.length * type.BYTES_PER_ELEMENT).buffer);
  });
}

/** The status of a call; an error is thrown. */
export function succeed(engine: Engine, status: number): number {
  if (status >= 0) return status;
  const { where, problem, remedy } = answerOf(engine) as FoldproofError;
  throw new FoldproofError(where, problem, remedy.replace('--steps-only', 'stepsOnly')); // an option of the program
}
