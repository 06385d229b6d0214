// All streamed data: frames, predictions, answers per triangle, boxes. Its size is bounded.
import { collisionsOf } from '../shared/steps';
import { getFloats, GoneError, type SceneInfo } from './api';
import { insideOf, type Check } from './check';
import type { LayerState } from './layers';
import { Ring } from './ring';
import { faceBytesOf, floatsOf } from './surface';

const kMegabyte = 1 << 20;

/** Bytes: half for frames, a quarter each for answers and predictions. Less on phones. */
function budget(): number {
  const memory = (navigator as { deviceMemory?: number }).deviceMemory ?? 8;
  const small = memory < 4 || matchMedia('(pointer: coarse)').matches;
  return (small ? 128 : 512) * kMegabyte;
}

export class Data {
  readonly frames: Ring<Float32Array<ArrayBuffer>>;
  readonly predictions: Ring<Float32Array<ArrayBuffer>>;
  /** Of the last repair; null without one. */
  repaired: Ring<Float32Array<ArrayBuffer>> | null = null;
  readonly faces: Ring<Uint8Array<ArrayBuffer>>;
  readonly budget = budget();
  boxes: { frame: number; level: number; data: Float32Array[] } | null = null;
  private boxesBusy = false;
  private boxesRetryAfter = 0;

  constructor(
    private readonly scene: SceneInfo,
    private readonly check: Check,
    private readonly layers: () => LayerState,
    private readonly changed: () => void,
    private readonly failed: (error: unknown) => void,
  ) {
    const floats = scene.objects.map(({ vertices }) => ({ elements: floatsOf(vertices), bytes: 12 * vertices }));
    const common = { loaded: changed, failed };
    const positions = { ...common, count: scene.frames, parts: floats, make: (n: number) => new Float32Array(n), needed: () => true };
    this.frames = new Ring({ ...positions, budget: this.budget / 2, path: (i, k) => `objects/${i}/frames/${k}` });
    this.predictions = new Ring({
      ...positions,
      // Objects without a prediction have no data.
      parts: floats.map((part, i) => (this.predicts(i) ? part : { elements: 0, bytes: 0 })),
      budget: this.budget / 4,
      path: (i, k) => `objects/${i}/prediction/${k}`,
    });
    this.faces = new Ring({
      ...common,
      count: Math.max(1, scene.steps),
      parts: scene.objects.map(({ triangles }) => ({ elements: faceBytesOf(triangles), bytes: 4 * triangles })),
      budget: this.budget / 4,
      make: (n) => new Uint8Array(n),
      path: (i, n) => `steps/${n}/faces/${i}`,
      needed: (n) => this.needsFaces(n),
    });
  }

  /** Begins anew with the frames of a repair, or without one. */
  setRepaired(exists: boolean): void {
    const { scene, changed, failed } = this;
    const parts = scene.objects.map(({ vertices }) => ({ elements: floatsOf(vertices), bytes: 12 * vertices }));
    this.repaired = exists
      ? new Ring({ loaded: changed, failed, count: scene.frames, parts, make: (n: number) => new Float32Array(n), needed: () => true, budget: this.budget / 4, path: (i, k) => `objects/${i}/repaired/${k}` })
      : null;
  }

  predicts(object: number): boolean {
    return (this.scene.objects[object]?.model?.key_points.length ?? 0) > 0;
  }

  /** Whether the current layers show any data of a step's triangles. */
  needsFaces(step: number): boolean {
    const answer = this.check.steps[step];
    if (!answer) return false;
    const { paint, collisions, meets } = this.layers();
    return paint === 'level' || paint === 'margin' || (collisions && insideOf(answer) > 0) || (meets && collisionsOf(answer) > 0);
  }

  bytes(): number {
    return this.frames.bytes() + this.predictions.bytes() + this.faces.bytes() + (this.repaired?.bytes() ?? 0);
  }

  /** Fetches the boxes of a frame, one request at a time. */
  async requestBoxes(frame: number, level: number): Promise<void> {
    if (this.boxesBusy || (this.boxes?.frame === frame && this.boxes.level === level) || performance.now() < this.boxesRetryAfter) return;
    this.boxesBusy = true;
    try {
      const data: Float32Array[] = [];
      for (let i = 0; i < this.scene.objects.length; ++i) data.push(await getFloats(`objects/${i}/boxes?frame=${frame}&level=${level}`));
      this.boxes = { frame, level, data };
      this.changed();
    } catch (error) {
      this.boxesRetryAfter = performance.now() + (error instanceof GoneError ? 1500 : 10_000);
      this.failed(error);
    } finally {
      this.boxesBusy = false;
    }
  }
}
