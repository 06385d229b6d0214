// Distances from the motion, of predictions or of a repair, measured when a frame is shown.
import type { SceneInfo } from './api';

export interface ErrorNow {
  scale: number;
  largest: number;
  rms: number;
}

export class Distances {
  /** The end of the color scale: it grows to the largest error, in round numbers. */
  scale = 0;
  private readonly measured = new Map<number, { largest: number; rms: number }>();

  constructor(private readonly scene: SceneInfo) {}

  measure(frame: number, object: number, truth: Float32Array, other: Float32Array): void {
    const key = frame * this.scene.objects.length + object;
    if (this.measured.has(key)) return;
    const n = 3 * this.scene.objects[object]!.vertices;
    let [largest, sum] = [0, 0];
    for (let c = 0; c < n; c += 3) {
      const d = (truth[c]! - other[c]!) ** 2 + (truth[c + 1]! - other[c + 1]!) ** 2 + (truth[c + 2]! - other[c + 2]!) ** 2;
      largest = Math.max(largest, d);
      sum += d;
    }
    this.measured.set(key, { largest: Math.sqrt(largest), rms: Math.sqrt((3 * sum) / n) });
    if (largest > this.scale ** 2) {
      const power = 10 ** Math.floor(Math.log10(Math.sqrt(largest)));
      this.scale = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= Math.sqrt(largest)) ?? 10 * power;
    }
  }

  /** Those of a frame, over all objects; null if none is measured. */
  at(frame: number): ErrorNow | null {
    let [largest, squares, count] = [0, 0, 0];
    this.scene.objects.forEach(({ vertices }, i) => {
      const error = this.measured.get(frame * this.scene.objects.length + i);
      if (!error) return;
      largest = Math.max(largest, error.largest);
      squares += vertices * error.rms ** 2;
      count += vertices;
    });
    return count > 0 ? { scale: this.scale, largest, rms: Math.sqrt(squares / count) } : null;
  }
}
