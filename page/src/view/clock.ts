// Where the timeline stands: a step and how far into it. Both are kept apart, so that the end of a step and the begin of the
// next one, which are the same place, stay what the user chose.

export class Clock {
  step = 0;
  t = 0; // in [0,1] of the step
  playing = false;
  speed = 1;
  loop = true;

  constructor(
    readonly steps: number,
    readonly substeps: number,
    readonly frames: number,
  ) {}

  /** The frame at or before this moment, among those selected. */
  get frame(): number {
    return Math.min(Math.floor(this.step / this.substeps), Math.max(0, this.frames - 2));
  }

  /** A single frame, in which no time passes. */
  get still(): boolean {
    return this.frames === 1;
  }

  /** How far from `frame` to the next one. */
  get blend(): number {
    return this.still ? 0 : (this.step - this.frame * this.substeps + this.t) / this.substeps;
  }

  /** In frames from the first selected one. */
  get place(): number {
    return this.still ? 0 : (this.step + this.t) / this.substeps;
  }

  get atEnd(): boolean {
    return this.still || (this.step === this.steps - 1 && this.t >= 1);
  }

  seek(step: number, t = 0): void {
    this.step = Math.min(Math.max(0, step), Math.max(0, this.steps - 1));
    this.t = this.still ? 0 : Math.min(Math.max(0, t), 1);
  }

  /** To a place in frames; the end of the last step is reached, other ends are the next begin. */
  seekPlace(place: number): void {
    const steps = Math.min(Math.max(0, place * this.substeps), this.steps);
    if (steps >= this.steps) this.seek(this.steps - 1, 1);
    else this.seek(Math.floor(steps), steps - Math.floor(steps));
  }

  /** Whole steps on or back; back within a step goes to its begin first. */
  move(by: number): void {
    if (by < 0 && this.t > 1e-6) {
      this.seek(this.step + by + 1, 0);
    } else if (this.step + by >= this.steps) {
      this.seek(this.steps - 1, 1);
    } else {
      this.seek(this.step + by, 0);
    }
  }

  /** Plays on by so many frames; false at an end where it stops. */
  advance(frames: number): boolean {
    const place = this.place + frames;
    const end = this.steps / this.substeps;
    if (place < end) {
      this.seekPlace(place);
      return true;
    }
    if (this.loop && end > 0) {
      this.seekPlace(place % end);
      return true;
    }
    this.seekPlace(end);
    return false;
  }
}
