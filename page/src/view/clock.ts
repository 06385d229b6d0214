// The timeline's position: a step and the time within it. Both are stored, because the end of a step and the start of the
// next one are the same position, but different choices of the user.

export class Clock {
  step = 0;
  t = 0; // in [0,1] of the step
  playing = false;
  speed = 1;
  loop = true;
  /** Positions between which it plays; null: from the begin to the end. */
  range: [number, number] | null = null;

  constructor(
    readonly steps: number,
    readonly substeps: number,
    readonly frames: number,
  ) {}

  /** The index of the frame at or before this moment. */
  get frame(): number {
    return Math.min(Math.floor(this.step / this.substeps), Math.max(0, this.frames - 2));
  }

  /** Whether there is only one frame, so that no time passes. */
  get still(): boolean {
    return this.frames === 1;
  }

  /** The share of the way from `frame` to the next one. */
  get blend(): number {
    return this.still ? 0 : (this.step - this.frame * this.substeps + this.t) / this.substeps;
  }

  /** In frames from the first selected one. */
  get position(): number {
    return this.still ? 0 : (this.step + this.t) / this.substeps;
  }

  get atEnd(): boolean {
    return this.still || (this.step === this.steps - 1 && this.t >= 1);
  }

  seek(step: number, t = 0): void {
    this.step = Math.min(Math.max(0, step), Math.max(0, this.steps - 1));
    this.t = this.still ? 0 : Math.min(Math.max(0, t), 1);
  }

  /** Moves to a position in frames. The end of a step becomes the start of the next one, except for the last. */
  seekPosition(position: number): void {
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
    const position = this.position + frames;
    const [begin, end] = this.range ?? [0, this.steps / this.substeps];
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
}
