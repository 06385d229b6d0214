// The model's shapes: sliders for the modes, the distance from the mean, and the certified radius.
import { el, setText } from '../shared/dom';
import { counted, percent, short } from '../shared/format';
import { getFloats, getJson, type ObjectInfo, type Radius } from './api';
import { floatsOf } from './surface';

const kMaxDeviations = 3;
const kRadii = 2; // Sliders first go to this multiple of the certified radius.
const kShownAtFirst = 8;
const kPollMs = 700;

export class ShapePanel {
  readonly element = el('div', { className: 'panel shapes' });
  readonly shape: Float32Array<ArrayBuffer>;
  version = 0;
  ready = false;
  norm = 0;
  radius: Radius | null = null;
  /** Per triangle: 1 where it is in a pair of patches that the proof leaves out; null if there are none. */
  uncertified: Uint8Array | null = null;

  private readonly sliders: HTMLInputElement[] = [];
  private readonly values: HTMLElement[] = [];
  private readonly coordinates: Float64Array; // in standard deviations
  private readonly norms = el('p', { className: 'norm' });
  private readonly wide = el('button', { className: 'small', type: 'button', hidden: true }, `Up to ${kMaxDeviations} σ`);
  private range = kMaxDeviations;
  private readonly verdict = el('p', { className: 'verdict' });
  private readonly about = el('p', { className: 'note' });
  private mean: Float32Array | null = null;
  private modes: Float32Array[] = [];
  private requested = false;

  constructor(
    private readonly object: ObjectInfo,
    private readonly index: number,
    private readonly changed: () => void,
    private readonly failed: (error: unknown) => void,
  ) {
    this.shape = new Float32Array(floatsOf(object.vertices));
    this.coordinates = new Float64Array(object.model?.modes ?? 0);
    this.build();
  }

  private build(): void {
    const model = this.object.model!;
    const rows = el('div', { className: 'sliders' });
    for (let j = 0; j < model.modes; ++j) {
      const slider = el('input', { type: 'range', min: String(-kMaxDeviations), max: String(kMaxDeviations), step: 'any', value: '0', 'aria-label': `Mode ${j + 1}, in standard deviations` });
      const value = el('output', {}, '0 σ');
      slider.addEventListener('input', () => this.set(j, Number(slider.value)));
      slider.addEventListener('dblclick', () => this.set(j, 0));
      this.sliders.push(slider);
      this.values.push(value);
      const row = el('label', { className: 'slider', hidden: j >= kShownAtFirst }, el('span', {}, `Mode ${j + 1}`), slider, value);
      row.title = `One standard deviation is ${short(model.deviations[j] ?? 0)} in mesh units; a double click goes back to the mean`;
      rows.append(row);
    }
    const more = el('button', { className: 'small', type: 'button', hidden: model.modes <= kShownAtFirst }, `All ${model.modes} modes`);
    more.addEventListener('click', () => {
      for (const row of rows.children) (row as HTMLElement).hidden = false;
      more.hidden = true;
    });
    const reset = el('button', { className: 'small', type: 'button', onclick: () => this.setAll(() => 0) }, 'Mean shape');
    const random = el('button', { className: 'small', type: 'button', title: 'Samples every mode from the normal distribution of the training poses', onclick: () => this.showLikely() }, 'A likely shape');
    this.wide.addEventListener('click', () => {
      this.setRange(kMaxDeviations);
      this.wide.hidden = true;
    });
    this.element.append(this.norms, this.verdict, el('div', { className: 'row' }, reset, random, more, this.wide), rows, this.about);
  }

  /** Loads the mean and the modes, and asks for the radius, when the panel is first opened. */
  open(): void {
    if (this.requested) return;
    this.requested = true;
    this.describe();
    void this.load();
    void this.askRadius();
  }

  private async load(): Promise<void> {
    const base = `objects/${this.index}/model`;
    try {
      this.mean = await getFloats(`${base}/mean`);
      this.compute();
      this.ready = true;
      this.changed();
      for (let j = 0; j < this.coordinates.length; ++j) {
        this.modes.push(await getFloats(`${base}/modes/${j}`));
        if (this.coordinates[j] !== 0) this.compute();
      }
    } catch (error) {
      this.requested = false;
      this.failed(error);
    }
  }

  private async askRadius(): Promise<void> {
    try {
      this.radius = await getJson<Radius>(`objects/${this.index}/model/radius`);
    } catch (error) {
      this.radius = { state: 'failed', error: String((error as Error).message) };
      this.failed(error);
    }
    const left = this.radius.uncertified_triangles ?? [];
    if (left.length > 0) {
      this.uncertified = new Uint8Array(this.object.triangles);
      for (const face of left) this.uncertified[face] = 1;
    }
    this.fitSliders();
    this.describe();
    this.changed();
    if (this.radius.state === 'computing') setTimeout(() => void this.askRadius(), kPollMs);
  }

  /** A radius far below the sliders' ends would be too small to be seen or hit: they end nearby until the user asks for all. */
  private fitSliders(): void {
    const radius = this.radius?.state === 'done' ? (this.radius.radius ?? 0) : 0;
    this.wide.hidden = !(radius > 0 && kRadii * radius < kMaxDeviations);
    if (!this.wide.hidden) this.setRange(kRadii * radius);
  }

  private setRange(range: number): void {
    this.range = Math.min(kMaxDeviations, range);
    for (const slider of this.sliders) {
      slider.min = String(-this.range);
      slider.max = String(this.range);
    }
    this.describe();
  }

  private set(mode: number, deviations: number): void {
    this.coordinates[mode] = deviations;
    this.compute();
  }

  private showLikely(): void {
    this.setRange(kMaxDeviations);
    this.wide.hidden = true;
    this.setAll(normal);
  }

  private setAll(value: () => number): void {
    for (let j = 0; j < this.coordinates.length; ++j) this.coordinates[j] = Math.min(kMaxDeviations, Math.max(-kMaxDeviations, value()));
    this.compute();
  }

  /** x = mean + sum of p_j mode_j. */
  private compute(): void {
    if (!this.mean) return;
    this.shape.set(this.mean);
    const { shape } = this;
    for (let j = 0; j < this.modes.length; ++j) {
      const p = this.coordinates[j]! * this.object.model!.deviations[j]!;
      if (p === 0) continue;
      const mode = this.modes[j]!;
      for (let k = 0; k < mode.length; ++k) shape[k] = shape[k]! + p * mode[k]!;
    }
    ++this.version;
    this.describe();
    this.changed();
  }

  get inside(): boolean | null {
    return this.radius?.state === 'done' ? this.norm < (this.radius.radius ?? 0) : null;
  }

  private describe(): void {
    let sum = 0;
    for (const c of this.coordinates) sum += c * c;
    this.norm = Math.sqrt(sum);
    const radius = this.radius?.state === 'done' ? (this.radius.radius ?? 0) : null;
    setText(this.norms, `Distance from the mean: ${short(this.norm)} σ` + (radius === null ? '' : `; certified radius ${short(radius)} σ`));
    this.sliders.forEach((slider, j) => {
      const c = this.coordinates[j]!;
      slider.value = String(c);
      setText(this.values[j]!, `${c > 0 ? '+' : ''}${c.toFixed(2)} σ`);
      // The range of this slider inside the radius while the others stay.
      const limit = radius === null ? 0 : Math.sqrt(Math.max(0, radius * radius - (sum - c * c)));
      const share = Math.min(1, limit / this.range);
      slider.style.setProperty('--in-from', `${50 - 50 * share}%`);
      slider.style.setProperty('--in-to', `${50 + 50 * share}%`);
    });
    this.showVerdict();
  }

  /** Whether the current shape is proven free; also shown over the picture. */
  verdictText(): { text: string; kind: 'inside' | 'outside' | 'open' } {
    const { radius } = this;
    if (!radius) return { text: 'Requesting the certified radius…', kind: 'open' };
    if (radius.state === 'computing') return { text: `Computing the certified radius: ${percent(radius.progress ?? 0)}`, kind: 'open' };
    if (radius.state === 'failed') return { text: `No certified radius: ${radius.error ?? 'it failed'}`, kind: 'open' };
    if (!this.inside) return { text: `Outside the certified radius (${short(this.norm)} σ from the mean, proven below ${short(radius.radius ?? 0)} σ): no part is proven here. ${this.farthest()}`, kind: 'outside' };
    const uncertified = radius.uncertified ?? 0;
    return {
      text: `Inside the certified radius: proven not to touch itself${uncertified > 0 ? `, but for ${counted(uncertified, 'pair')} of patches` : ''}`,
      kind: 'inside',
    };
  }

  /** The slider that goes farthest. */
  private farthest(): string {
    let far = 0;
    this.coordinates.forEach((c, j) => {
      if (Math.abs(c) > Math.abs(this.coordinates[far]!)) far = j;
    });
    return `Mode ${far + 1} goes farthest, ${short(Math.abs(this.coordinates[far] ?? 0))} σ`;
  }

  private showVerdict(): void {
    const { text, kind } = this.verdictText();
    setText(this.verdict, text);
    this.verdict.dataset['kind'] = kind;
    const done = this.radius?.state === 'done' ? this.radius : null;
    const model = this.object.model!;
    const parts = [`σ: standard deviations of ${counted(model.poses, 'training pose')}. Green on a slider: inside the certified radius, the others as they are.`];
    if (done?.share !== undefined) parts.push(`${percent(done.share)} of a normal distribution of shapes lies inside it.`);
    if (done?.uncertified) parts.push(`${counted(done.uncertified, 'pair')} of patches that touch or nearly touch in the mean shape ${done.uncertified === 1 ? 'is' : 'are'} not covered (orange on the shape); foldproof radius lists them.`);
    setText(this.about, parts.join(' '));
  }
}

/** A normally distributed number (Box and Muller). */
function normal(): number {
  return Math.sqrt(-2 * Math.log(1 - Math.random())) * Math.cos(2 * Math.PI * Math.random());
}
