// The check as it goes on: its steps, and the pairs of the step that is looked at.
import { collisionsOf, type Step } from '../shared/steps';
import { ApiError, getJson, type Pair, type StepsAnswer } from './api';

const kPollMs = 400;
const kPage = 1000;
const kMostListed = 10_000; // More than anyone reads; the program has the rest (check --csv).
const kKept = 48; // steps whose pairs are kept

export class Check {
  readonly steps: Step[] = [];
  state: StepsAnswer['state'] = 'running';
  error = '';
  total = 0;
  done = 0;
  pairs = 0;
  colliding = 0;

  constructor(
    private readonly changed: (from: number) => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  start(): void {
    void this.poll();
  }

  /** The next step with collisions from `step` on in a direction, or -1. */
  nextColliding(step: number, direction: 1 | -1): number {
    for (let n = step + direction; n >= 0 && n < this.steps.length; n += direction) {
      if (collisionsOf(this.steps[n]!) > 0) return n;
    }
    return -1;
  }

  private async poll(): Promise<void> {
    let wait = kPollMs;
    try {
      const from = this.steps.length;
      const answer = await getJson<StepsAnswer>(`steps?from=${from}`);
      for (const step of answer.steps) {
        this.steps.push(step);
        this.pairs += collisionsOf(step);
        if (collisionsOf(step) > 0) ++this.colliding;
      }
      this.state = answer.state;
      this.error = answer.error ?? '';
      this.total = answer.total;
      this.done = Math.max(answer.done, this.steps.length);
      this.changed(from);
      if (this.steps.length >= answer.done && answer.state !== 'running') return;
      if (answer.steps.length === 1000) wait = 0;
    } catch (error) {
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
  items: Pair[]; // by time of impact, once there are no more to come
  complete: boolean;
}

/** Pairs of steps, fetched when they are looked at. */
export class PairStore {
  private readonly kept = new Map<number, PairsOfStep>(); // oldest first
  private busy = false;
  private wish = -1;
  private wishAll = false;

  constructor(
    private readonly arrived: (pairs: PairsOfStep) => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  get(step: number): PairsOfStep | undefined {
    return this.kept.get(step);
  }

  /** Fetches a step's first pairs, or all that are listed. */
  want(step: number, all: boolean): void {
    this.wish = step;
    this.wishAll = all;
    if (!this.busy) void this.work();
  }

  private unfinished(): boolean {
    const pairs = this.kept.get(this.wish);
    return this.wish >= 0 && (!pairs || (this.wishAll && !pairs.complete));
  }

  private async work(): Promise<void> {
    this.busy = true;
    try {
      while (this.unfinished()) await this.page(this.wish);
    } catch (error) {
      this.wish = -1;
      this.failed(error);
    }
    this.busy = false;
  }

  private async page(step: number): Promise<void> {
    const pairs = this.kept.get(step) ?? { step, total: 0, items: [], complete: false };
    const answer = await getJson<{ total: number; items: Pair[] }>(`steps/${step}/collisions?offset=${pairs.items.length}&limit=${kPage}`);
    pairs.total = answer.total;
    pairs.items.push(...answer.items);
    pairs.complete = answer.items.length === 0 || pairs.items.length >= Math.min(answer.total, kMostListed);
    this.kept.delete(step);
    this.kept.set(step, pairs);
    if (this.kept.size > kKept) this.kept.delete(this.kept.keys().next().value as number);
    this.arrived(pairs);
  }
}
