// Foldproof for JavaScript: every collision of deforming triangle meshes, continuously in time.
import createEngine, { type Engine } from './engine.js';
import { Memory, answerOf, succeed } from './memory.js';
import { Meshes, requireObject, sized } from './meshes.js';
import { kCheckDefaults, kStepDefaults, settingsJson } from './settings.js';
import { FoldproofError, type CheckResult, type CheckSettings, type Contact, type Mesh, type Motion, type Rows, type StaticResult, type StepPlace, type StepResult, type StepSettings } from './types.js';

export * from './types.js';

const kTurnMilliseconds = 20; // of work, before others have their turn

let loading: Promise<Engine> | undefined;
const load = (): Promise<Engine> => (loading ??= createEngine());

const listOf = <T>(one: T | readonly T[]): readonly T[] => (Array.isArray(one) ? one : [one as T]);
const nameOf = (list: readonly unknown[], k: number, what: string): string => (list.length > 1 ? `${what} ${k}` : what);
const othersTurn = (): Promise<void> => new Promise((resolve) => setTimeout(resolve, 0));

/** Keys as they are in JavaScript: curve_length is curveLength. */
function camelCase(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(camelCase);
  if (typeof value !== 'object' || value === null || ArrayBuffer.isView(value)) return value;
  return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key.replace(/_(.)/g, (_, letter: string) => letter.toUpperCase()), camelCase(inner)]));
}

/** What one part of a check answers. */
interface Part {
  start?: StaticResult;
  step?: StepPlace & StepResult;
  end?: Omit<CheckResult, 'steps' | 'startCrossings'> & { contacts: unknown };
}

/** How many steps a check has. */
const stepsOf = (frames: number, settings: CheckSettings): number => (settings.static ? frames : Math.max(1, frames - 1) * (settings.substeps ?? 1));

/**
 * Checks a motion, or several that move together: which triangles cross in the first frame, then what touches in every step.
 * No pair that touches is missing. Lets others have their turn while it works; for motions of seconds call it in a worker.
 * Throws FoldproofError for meshes, motions and settings that it refuses.
 */
export async function check(motions: Motion | readonly Motion[], settings: CheckSettings & { static: true }): Promise<CheckResult<StaticResult>>;
export async function check(motions: Motion | readonly Motion[], settings?: CheckSettings): Promise<CheckResult>;
export async function check(motions: Motion | readonly Motion[], given: CheckSettings = {}): Promise<CheckResult | CheckResult<StaticResult>> {
  requireObject(given, 'settings', 'settings by name');
  const { onProgress, signal, ...settings } = given;
  const json = settingsJson(kCheckDefaults, settings);
  signal?.throwIfAborted();
  const engine = await load();
  const meshes = new Meshes(engine);
  const memory = new Memory(engine);
  let handle = 0;
  try {
    const list = listOf(motions);
    if (settings.within === false && list.length === 1) throw new FoldproofError('within', 'is off, but there is only one motion, so nothing would be tested', 'leave it on, or give more motions');
    let frames = 0;
    for (let k = 0; k < list.length; ++k) frames = await meshes.add(list[k]!, nameOf(list, k, 'motion'));
    succeed(engine, engine._foldproof_open_check(meshes.handle, memory.text(json)));
    ({ handle } = answerOf(engine) as { handle: number });
    return await runCheck(engine, handle, stepsOf(frames, settings), onProgress, signal);
  } finally {
    if (handle !== 0) engine._foldproof_drop_check(handle);
    meshes.drop();
    memory.free();
  }
}

async function runCheck(engine: Engine, handle: number, count: number, onProgress?: (share: number) => void, signal?: AbortSignal): Promise<CheckResult> {
  const steps: (StepPlace & StepResult)[] = [];
  let startCrossings = null;
  let turn = performance.now();
  for (;;) {
    const more = succeed(engine, engine._foldproof_advance(handle)) > 0;
    const { start, step, end } = answerOf(engine) as Part;
    if (start) startCrossings = start.crossings;
    if (step) steps.push(step);
    if (end) return { ...end, startCrossings, steps, contacts: camelCase(end.contacts) as Contact[] };
    if (!more) throw new Error('the check ended without an answer');
    if (step) onProgress?.(steps.length / count);
    if (performance.now() - turn > kTurnMilliseconds) {
      await othersTurn();
      signal?.throwIfAborted();
      turn = performance.now();
    }
  }
}

/** What a StepChecker holds of the engine. */
interface Held {
  engine: Engine;
  handle: number;
  memory: Memory;
}

function release({ engine, handle, memory }: Held): void {
  engine._foldproof_drop_checker(handle);
  memory.free();
}

const forgotten = new FinalizationRegistry(release);

/** Checks step by step, as a simulation or an animation goes, and remembers what it has proven. */
export class StepChecker {
  private held: Held | undefined;
  private readonly x0: number;
  private readonly x1: number;

  private constructor(
    held: Held,
    private readonly vertexCounts: readonly number[],
  ) {
    this.held = held;
    const bytes = 24 * vertexCounts.reduce((sum, count) => sum + count, 0);
    this.x0 = held.memory.bytes(bytes);
    this.x1 = held.memory.bytes(bytes);
    forgotten.register(this, held, held);
  }

  /** Of a mesh, or of several that move together. */
  static async create(meshes: Mesh | readonly Mesh[]): Promise<StepChecker> {
    const engine = await load();
    const gathered = new Meshes(engine);
    try {
      const list = listOf(meshes);
      list.forEach((mesh, k) => {
        const where = nameOf(list, k, 'mesh');
        requireObject(mesh, where, 'faces and positions');
        gathered.start(mesh, where);
        gathered.frame(mesh.positions, `${where}.positions`);
      });
      succeed(engine, engine._foldproof_open_checker(gathered.handle));
      const { handle } = answerOf(engine) as { handle: number };
      return new StepChecker({ engine, handle, memory: new Memory(engine) }, gathered.vertexCounts);
    } finally {
      gathered.drop();
    }
  }

  /**
   * Every pair of features that touches while all vertices move from x0 to x1 along straight lines. With several meshes, x0
   * and x1 are arrays with the positions of each. Throws FoldproofError.
   */
  check(x0: Rows | readonly Rows[], x1: Rows | readonly Rows[], settings: StepSettings = {}): StepResult {
    return this.ask(settings, (held, json) => held.engine._foldproof_check_step(held.handle, this.put(held, x0, this.x0, 'x0'), this.put(held, x1, this.x1, 'x1'), json)) as StepResult;
  }

  /** Every two triangles that cross in this pose. */
  checkStatic(x: Rows | readonly Rows[], settings: StepSettings = {}): StaticResult {
    return this.ask(settings, (held, json) => held.engine._foldproof_check_pose(held.handle, this.put(held, x, this.x0, 'x'), json), 'checkStatic') as StaticResult;
  }

  /** Gives its memory back at once; otherwise that happens some time after the last use. */
  free(): void {
    if (!this.held) return;
    forgotten.unregister(this.held);
    release(this.held);
    this.held = undefined;
  }

  private ask(settings: StepSettings, call: (held: Held, json: number) => number, poses = ''): unknown {
    if (!this.held) throw new FoldproofError('StepChecker', 'has been freed', 'make another one');
    const { engine } = this.held;
    const memory = new Memory(engine);
    try {
      succeed(engine, call(this.held, memory.text(settingsJson(kStepDefaults, { ...settings }, poses))));
      return answerOf(engine);
    } finally {
      memory.free();
    }
  }

  /** Writes positions of all objects to `at`. */
  private put({ engine }: Held, x: Rows | readonly Rows[], at: number, where: string): number {
    const counts = this.vertexCounts;
    const all = counts.length > 1 ? (x as readonly Rows[]) : [x as Rows];
    if (all.length !== counts.length) throw new FoldproofError(where, `has positions of ${all.length} meshes instead of ${counts.length}`, 'give an array for each mesh');
    let to = at / 8;
    counts.forEach((count, k) => {
      engine.HEAPF64.set(sized(all[k]!, count, nameOf(counts, k, where)), to);
      to += 3 * count;
    });
    return at;
  }
}
