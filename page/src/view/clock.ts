// The timeline's position: a step and the time within it. Both are stored, because the end of a step and the start of the
// next one are the same position, but different choices of the user.
import { isStatic } from '../shared/words';
import type { SceneInfo } from './api';

export class Clock {
  step = 0;
  t = 0; // in [0,1] of the step
  playing = false;
  speed: number;
  loop = true;
  /** Positions between which it plays; null: from the begin to the end. */
  range: [number, number] | null = null;

  readonly steps: number;
  readonly substeps: number;
  readonly frames: number;
  /** Steps are poses, in which no time passes. */
  readonly still: boolean;
  private played = 0; // how long a pose has been shown while playing, in frames

  constructor({ steps, substeps, frames, settings }: SceneInfo) {
    this.still = frames === 1 || isStatic(settings);
    this.steps = steps;
    this.substeps = this.still ? 1 : substeps;
    this.frames = frames;
    this.speed = isStatic(settings) ? 0.1 : 1; // Poses are no motion: each needs time to be seen.
  }

  /** The index of the frame at or before this moment. */
  get frame(): number {
    return this.still ? this.step : Math.min(Math.floor(this.step / this.substeps), this.frames - 2);
  }

  /** The share of the way from `frame` to the next one. */
  get blend(): number {
    return this.still ? 0 : (this.step - this.frame * this.substeps + this.t) / this.substeps;
  }

  /** In frames from the first selected one. */
  get position(): number {
    return (this.step + this.t) / this.substeps;
  }

  /** The last position. */
  get end(): number {
    return this.frames - 1;
  }

  get atEnd(): boolean {
    return this.position >= this.end;
  }

  seek(step: number, t = 0): void {
    this.step = Math.min(Math.max(0, step), Math.max(0, this.steps - 1));
    this.t = this.still ? 0 : Math.min(Math.max(0, t), 1);
  }

  /** Moves to a position in frames, or to the nearest pose. The end of a step becomes the start of the next one, except for the last. */
  seekPosition(position: number): void {
    if (this.still) return this.seek(Math.round(position));
    const steps = Math.min(Math.max(0, position * this.substeps), this.steps);
    if (steps >= this.steps) this.seek(this.steps - 1, 1);
    else this.seek(Math.floor(steps), steps - Math.floor(steps));
  }

  /** Moves by whole steps. Backward from within a step, the first move goes to its start. */
  move(by: number): void {
    if (by < 0 && this.t > 1e-6) {
      this.seek(this.step + by + 1, 0);
    } else if (this.step + by >= this.steps) {
      this.seek(this.steps - 1, 1);
    } else {
      this.seek(this.step + by, 0);
    }
  }

  /** Advances by so many frames; false at an end where playing stops. */
  advance(frames: number): boolean {
    const position = this.position + this.toAdvance(frames);
    const [begin, last] = this.range ?? [0, this.end];
    const end = this.still ? last + 1 : last; // The last pose is shown, too.
    if (position < end) {
      this.seekPosition(Math.max(begin, position));
      return true;
    }
    if (this.loop && end > begin) {
      this.seekPosition(begin + ((position - end) % (end - begin)));
      return true;
    }
    this.seekPosition(end);
    return false;
  }

  /** Poses follow each other in whole frames. */
  private toAdvance(frames: number): number {
    if (!this.still) return frames;
    this.played += frames;
    const whole = Math.floor(this.played);
    this.played -= whole;
    return whole;
  }
}
