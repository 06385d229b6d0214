// A cache of numbered, equally large pieces (frames, answers of steps) that never holds more than its budget. It fetches
// ahead of where the timeline stands and gives up what lies farthest ahead of it, which is what was just played.
import { getInto } from './api';

export interface Slot<T> {
  key: number;
  ready: boolean;
  parts: T[]; // one array per object, padded to whole rows of a texture
}

export interface PartSize {
  elements: number; // with padding
  bytes: number; // of the answer, without
}

type Array_ = Float32Array<ArrayBuffer> | Uint8Array<ArrayBuffer>;

export interface RingOptions<T extends Array_> {
  count: number; // keys 0 to count - 1
  parts: PartSize[];
  budget: number; // bytes
  make: (elements: number) => T;
  path: (part: number, key: number) => string;
  wanted: (key: number) => boolean; // asked for each key before it is fetched
  arrived: (key: number) => void;
  failed: (error: unknown) => void;
}

const kAtOnce = 3; // A browser opens six connections to a host, and others want some.
const kRetryMs = 1500;

export class Ring<T extends Array_> {
  private readonly slots: Slot<T>[] = [];
  private readonly byKey = new Map<number, Slot<T>>();
  private readonly capacity: number;
  private readonly slotBytes: number;
  private now = 0;
  private loading = 0;
  private restUntil = 0;

  constructor(private readonly options: RingOptions<T>) {
    const width = options.make(0).BYTES_PER_ELEMENT;
    this.slotBytes = Math.max(1, options.parts.reduce((sum, part) => sum + part.elements * width, 0));
    // Three is what a step between two frames and the next one need.
    this.capacity = Math.min(options.count, Math.max(3, Math.floor(options.budget / this.slotBytes)));
  }

  bytes(): number {
    return this.slots.length * this.slotBytes;
  }

  get(key: number): Slot<T> | undefined {
    const slot = this.byKey.get(key);
    return slot?.ready ? slot : undefined;
  }

  /** How many keys from this one on are there. */
  ahead(key: number): number {
    let n = 0;
    while (n < this.capacity && this.get((key + n) % this.options.count)) ++n;
    return n;
  }

  /** Fetches from this key on. */
  aim(key: number): void {
    this.now = key;
    this.pump();
  }

  /** Drops all there is, because it would be answered differently now. */
  clear(): void {
    for (const slot of this.slots) if (slot.ready) this.drop(slot);
  }

  private drop(slot: Slot<T>): void {
    this.byKey.delete(slot.key);
    slot.key = -1;
    slot.ready = false;
  }

  private distance(key: number): number {
    return (key - this.now + this.options.count) % this.options.count;
  }

  private pump(): void {
    if (this.loading >= kAtOnce || performance.now() < this.restUntil) return;
    for (let d = 0; d < this.capacity && this.loading < kAtOnce; ++d) {
      const key = (this.now + d) % this.options.count;
      if (this.byKey.has(key) || !this.options.wanted(key)) continue;
      const slot = this.takeSlot(d);
      if (!slot) return;
      void this.load(slot, key);
    }
  }

  private takeSlot(distance: number): Slot<T> | undefined {
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
      this.options.arrived(key);
    } catch (error) {
      this.drop(slot);
      this.restUntil = performance.now() + kRetryMs;
      setTimeout(() => this.pump(), kRetryMs + 50);
      this.options.failed(error);
    } finally {
      --this.loading;
    }
    this.pump();
  }
}
