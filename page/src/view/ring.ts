// A cache of numbered entries of equal size (frames, answers of steps) with a bounded size. It prefetches entries after the
// timeline's position and evicts the farthest ones after it, cyclically, which are those just played.
import { getInto } from './api';

export interface Slot<T> {
  key: number;
  ready: boolean;
  parts: T[]; // one array per object, padded to complete rows of a texture
}

export interface PartSize {
  elements: number; // with padding
  bytes: number; // of the answer, without padding
}

type Array_ = Float32Array<ArrayBuffer> | Uint8Array<ArrayBuffer>;

export interface RingOptions<T extends Array_> {
  count: number; // keys 0 to count - 1
  parts: PartSize[];
  budget: number; // bytes
  make: (elements: number) => T;
  path: (part: number, key: number) => string;
  needed: (key: number) => boolean; // called for each key before it is fetched
  loaded: (key: number) => void;
  failed: (error: unknown) => void;
}

const kMaxLoads = 3; // A browser opens six connections to a host; some remain for other requests.
const kRetryMs = 1500;

export class Ring<T extends Array_> {
  private readonly slots: Slot<T>[] = [];
  private readonly byKey = new Map<number, Slot<T>>();
  private readonly capacity: number;
  private readonly slotBytes: number;
  private now = 0;
  private loading = 0;
  private retryAfter = 0;

  constructor(private readonly options: RingOptions<T>) {
    const width = options.make(0).BYTES_PER_ELEMENT;
    this.slotBytes = Math.max(1, options.parts.reduce((sum, part) => sum + part.elements * width, 0));
    // A step between two frames and the next one need three.
    this.capacity = Math.min(options.count, Math.max(3, Math.floor(options.budget / this.slotBytes)));
  }

  bytes(): number {
    return this.slots.length * this.slotBytes;
  }

  get(key: number): Slot<T> | undefined {
    const slot = this.byKey.get(key);
    return slot?.ready ? slot : undefined;
  }

  /** The number of consecutive keys from this one on that are loaded. */
  ahead(key: number): number {
    let n = 0;
    while (n < this.capacity && this.get((key + n) % this.options.count)) ++n;
    return n;
  }

  /** Fetches from this key on. */
  prefetch(key: number): void {
    this.now = key;
    this.loadNext();
  }

  private drop(slot: Slot<T>): void {
    this.byKey.delete(slot.key);
    slot.key = -1;
    slot.ready = false;
  }

  private distance(key: number): number {
    return (key - this.now + this.options.count) % this.options.count;
  }

  private loadNext(): void {
    if (this.loading >= kMaxLoads || performance.now() < this.retryAfter) return;
    for (let d = 0; d < this.capacity && this.loading < kMaxLoads; ++d) {
      const key = (this.now + d) % this.options.count;
      if (this.byKey.has(key) || !this.options.needed(key)) continue;
      const slot = this.freeSlot(d);
      if (!slot) return;
      void this.load(slot, key);
    }
  }

  private freeSlot(distance: number): Slot<T> | undefined {
    const free = this.slots.find((slot) => slot.key < 0);
    if (free) return free;
    if (this.slots.length < this.capacity) {
      const slot: Slot<T> = { key: -1, ready: false, parts: this.options.parts.map((part) => this.options.make(part.elements)) };
      this.slots.push(slot);
      return slot;
    }
    let farthest: Slot<T> | undefined;
    for (const slot of this.slots) {
      if (slot.ready && (!farthest || this.distance(slot.key) > this.distance(farthest.key))) farthest = slot;
    }
    if (!farthest || this.distance(farthest.key) <= distance) return undefined;
    this.drop(farthest);
    return farthest;
  }

  private async load(slot: Slot<T>, key: number): Promise<void> {
    slot.key = key;
    this.byKey.set(key, slot);
    ++this.loading;
    try {
      const { parts, path } = this.options;
      for (let i = 0; i < parts.length; ++i) {
        if (parts[i]!.bytes > 0) await getInto(path(i, key), new Uint8Array(slot.parts[i]!.buffer), parts[i]!.bytes);
      }
      slot.ready = true;
      this.options.loaded(key);
    } catch (error) {
      this.drop(slot);
      this.retryAfter = performance.now() + kRetryMs;
      setTimeout(() => this.loadNext(), kRetryMs + 50);
      this.options.failed(error);
    } finally {
      --this.loading;
    }
    this.loadNext();
  }
}
