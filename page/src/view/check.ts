// The progress of the check: its steps, and the pairs of the current step.
import { collisionsOf, type Step } from '../shared/steps';
import { verdictOf, type Answer, type Found, type Start, type Verdict } from '../shared/verdict';
import { isStatic } from '../shared/words';
import { ApiError, getJson, GoneError, type Bounds, type Pair, type SceneInfo, type StepsAnswer } from './api';

const kPollMs = 400;
const kAliveMs = 5000;
const kPage = 1000;
const kMaxListed = 10_000; // More than anyone reads; check --csv writes all.
const kMaxCached = 48; // steps
export const kStart = -1; // the first frame, in place of a step's number

/** The result of a step: something is inside something at its begin or end, or meets it between; it is proven free; or it only has no new contact, and it is not known what is inside. */
export type StepKind = 'hit' | 'free' | 'calm';

/** How many triangles cross or are inside at the begin or the end of a step, whichever are more. */
export const insideOf = ({ inside: [begin, end] }: Step): number => Math.max(begin ?? 0, end ?? 0);

export class Check {
  readonly steps: Step[] = [];
  state: Found['state'] = 'running';
  error = '';
  answer: Answer | null = null; // at the end
  total = 0;
  done = 0;
  pairs = 0;
  listed = 0; // of the pairs
  free = 0; // the number of steps that are proven free
  calm = false; // some step has no contact but is not proven free
  start: Start | null = null;
  /** The bounds at the end of each step. */
  readonly bounds: Bounds[] = [];
  /** Steps are poses, each checked by itself. */
  readonly poses: boolean;

  constructor(
    private readonly scene: SceneInfo,
    private readonly changed: (from: number) => void,
    private readonly failed: (error: unknown) => void,
  ) {
    this.poses = isStatic(scene.settings);
  }

  startPolling(): void {
    void this.poll();
  }

  get startsCrossing(): boolean {
    return (this.start?.crossings ?? 0) > 0;
  }

  kindOf(step: Step): StepKind {
    if (collisionsOf(step) > 0 || insideOf(step) > 0) return 'hit';
    // Nothing crosses at its begin and no pair meets: so it is free throughout.
    return this.poses || step.inside[0] === 0 ? 'free' : 'calm';
  }

  verdict(): Verdict {
    return verdictOf(this.found());
  }

  found(): Found {
    const { answer, done, pairs, start, state } = this;
    return { state, done, total: this.scene.steps, pairs, start, single: this.scene.frames === 1, poses: this.poses, assumed: this.scene.assumed, answer };
  }

  /** The next step with collisions in a direction, or kStart; null if there is none. */
  nextColliding(step: number, t: number, direction: 1 | -1): number | null {
    const first = this.steps[0];
    // Before the contacts of the first step, the position counts as the start.
    const from = direction > 0 && step === 0 && this.startsCrossing && first && t < first.toi ? kStart : step;
    for (let n = from + direction; n >= 0 && n < this.steps.length; n += direction) {
      if (collisionsOf(this.steps[n]!) > 0) return n;
    }
    return direction < 0 && this.startsCrossing && (step > 0 || t > 0) ? kStart : null;
  }

  private async poll(): Promise<void> {
    let wait = kPollMs;
    try {
      const from = this.steps.length;
      const answer = await getJson<StepsAnswer>(`steps?from=${from}`);
      for (const step of answer.steps) {
        this.steps.push(step);
        this.bounds.push({ low: step.low, high: step.high });
        this.pairs += collisionsOf(step);
        this.listed += step.listed;
        const kind = this.kindOf(step);
        if (kind === 'free') ++this.free;
        if (kind === 'calm') this.calm = true;
      }
      this.start = answer.start;
      // The program may be done while the last thousand steps are still to be fetched.
      this.state = answer.state === 'done' && this.steps.length < answer.done ? 'running' : answer.state;
      this.error = answer.error ?? '';
      this.answer = answer.verdict;
      this.total = answer.total;
      this.done = Math.max(answer.done, this.steps.length);
      this.changed(from);
      // Afterwards it is asked only whether it is still there.
      if (this.steps.length >= answer.done && answer.state !== 'running') wait = kAliveMs;
      else if (answer.steps.length === kPage) wait = 0;
    } catch (error) {
      if (this.state === 'running') {
        this.state = error instanceof GoneError ? 'gone' : 'failed';
        this.error = error instanceof Error ? error.message : String(error);
        this.changed(this.steps.length);
      }
      this.failed(error);
      if (error instanceof ApiError) return;
      wait = 2000;
    }
    setTimeout(() => void this.poll(), wait);
  }
}

export interface PairsOfStep {
  step: number;
  total: number;
  items: Pair[]; // by time of impact
  complete: boolean;
}

/** Pairs of steps and of the first frame (kStart), fetched on demand. */
export class PairStore {
  private readonly cached = new Map<number, PairsOfStep>(); // oldest first
  private busy = false;
  private requested: number | null = null;
  private requestedAll = false;

  constructor(
    private readonly arrived: (pairs: PairsOfStep) => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  get(step: number): PairsOfStep | undefined {
    return this.cached.get(step);
  }

  /** Fetches the first pairs of a step or of kStart, or all that are listed. */
  request(step: number, all: boolean): void {
    this.requested = step;
    this.requestedAll = all;
    if (!this.busy) void this.work();
  }

  private unfinished(): boolean {
    const pairs = this.requested === null ? undefined : this.cached.get(this.requested);
    return this.requested !== null && (!pairs || (this.requestedAll && !pairs.complete));
  }

  private async work(): Promise<void> {
    this.busy = true;
    try {
      while (this.unfinished()) await this.page(this.requested!);
    } catch (error) {
      this.requested = null;
      this.failed(error);
    }
    this.busy = false;
  }

  private async page(step: number): Promise<void> {
    const pairs = this.cached.get(step) ?? { step, total: 0, items: [], complete: false };
    const path = step === kStart ? 'start/crossings' : `steps/${step}/collisions`;
    const answer = await getJson<{ total: number; items: Pair[] }>(`${path}?offset=${pairs.items.length}&limit=${kPage}`);
    pairs.total = answer.total;
    pairs.items.push(...answer.items);
    pairs.complete = answer.items.length === 0 || pairs.items.length >= Math.min(answer.total, kMaxListed);
    this.cached.delete(step);
    this.cached.set(step, pairs);
    if (this.cached.size > kMaxCached) this.cached.delete(this.cached.keys().next().value as number);
    this.arrived(pairs);
  }
}
