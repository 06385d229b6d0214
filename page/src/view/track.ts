// What the timeline draws: a ruler of frames, the answers of all steps, and a lane for contacts of the same two parts. The wheel zooms; dragging the
// ruler marks a range to loop.
import { el } from '../shared/dom';
import { namesText } from '../shared/contact';
import { collisionsOf } from '../shared/steps';
import type { SceneInfo } from './api';
import { insideOf, type Check } from './check';
import type { Clock } from './clock';
import type { Contacts } from './contacts';

const kRuler = 18;
const kStrip = 26;
const kLane = 17;
const kMaxLanes = 200;
const kMeets = 4; // at the bottom of the strip
const kStillPixels = 3;

export interface TrackActions {
  seek: (position: number) => void;
  choose: (index: number) => void; // a contact
  hover: (position: number, x: number, lane: number | null) => void;
  leave: () => void;
}

type Color = (name: string) => string;

export class Track {
  readonly element: HTMLElement;
  private readonly strip = el('canvas', { className: 'strip' });
  private readonly lanes = el('canvas', { className: 'lane-picture' });
  private readonly lanesBox = el('div', { className: 'lanes', hidden: true });
  private readonly cursor = el('div', { className: 'cursor' });
  private view: [number, number]; // positions at the left and the right end
  private readonly ends: [number, number]; // the farthest that there are
  private readonly margin: number; // what a pose takes before and after its position
  private chosen: number | null = null;
  private corrections: number[] = [];

  constructor(
    private readonly scene: SceneInfo,
    private readonly clock: Clock,
    private readonly check: Check,
    private readonly contacts: Contacts,
    private readonly actions: TrackActions,
  ) {
    this.margin = clock.still ? 0.5 : 0;
    this.ends = [-this.margin, clock.end + this.margin];
    this.view = this.ends;
    this.lanesBox.append(this.lanes);
    this.element = el(
      'div',
      { className: 'track', tabIndex: 0, role: 'slider', 'aria-label': 'Timeline, in frames', 'aria-valuemin': '0', 'aria-valuemax': String(scene.frames - 1), title: '' },
      this.strip,
      this.lanesBox,
      this.cursor,
    );
    this.listen();
    new ResizeObserver(() => this.paint()).observe(this.element);
  }

  private get width(): number {
    return Math.max(1, this.strip.clientWidth);
  }

  private toX(position: number): number {
    const [from, to] = this.view;
    return ((position - from) / (to - from)) * this.width;
  }

  private positionAt(clientX: number): number {
    const [from, to] = this.view;
    const share = (clientX - this.element.getBoundingClientRect().left) / this.width;
    return Math.min(Math.max(0, from + share * (to - from)), this.clock.end);
  }

  private listen(): void {
    let pressed: { x: number; position: number; ruler: boolean } | null = null;
    const { element } = this;
    element.addEventListener('pointerdown', (event) => {
      if (this.laneAt(event) !== null) return;
      element.setPointerCapture(event.pointerId);
      const ruler = event.clientY - element.getBoundingClientRect().top < kRuler;
      pressed = { x: event.clientX, position: this.positionAt(event.clientX), ruler };
      if (!ruler) this.actions.seek(pressed.position);
    });
    element.addEventListener('pointermove', (event) => {
      if (pressed?.ruler && Math.abs(event.clientX - pressed.x) > kStillPixels) this.setRange(pressed.position, this.positionAt(event.clientX));
      else if (pressed && !pressed.ruler) this.actions.seek(this.positionAt(event.clientX));
      this.actions.hover(this.positionAt(event.clientX), event.clientX - element.getBoundingClientRect().left, this.laneAt(event));
    });
    element.addEventListener('pointerup', (event) => {
      if (pressed?.ruler && Math.abs(event.clientX - pressed.x) <= kStillPixels) {
        if (this.clock.range) this.setRange(0, 0);
        this.actions.seek(pressed.position);
      }
      pressed = null;
    });
    element.addEventListener('pointerleave', () => this.actions.leave());
    element.addEventListener('click', (event) => {
      const lane = this.laneAt(event);
      if (lane !== null) this.actions.choose(this.contacts.nearest(this.contacts.groups[lane]!, this.positionAt(event.clientX)));
    });
    element.addEventListener('dblclick', () => this.zoomTo(...this.ends));
    element.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
  }

  private laneAt(event: MouseEvent): number | null {
    if (event.target !== this.lanes) return null;
    const lane = Math.floor((event.clientY - this.lanes.getBoundingClientRect().top) / kLane);
    return lane < this.contacts.groups.length ? lane : null;
  }

  private wheel(event: WheelEvent): void {
    const overLanes = event.target === this.lanes && this.lanesBox.scrollHeight > this.lanesBox.clientHeight;
    if (overLanes && !event.ctrlKey) return; // scrolls the lanes
    event.preventDefault();
    const [from, to] = this.view;
    const [first, last] = this.ends;
    if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      const by = ((event.deltaX || event.deltaY) / this.width) * (to - from);
      const shift = Math.min(Math.max(by, first - from), last - to);
      return this.zoomTo(from + shift, to + shift);
    }
    const at = this.positionAt(event.clientX);
    const size = Math.min(last - first, Math.max(2 / this.clock.substeps, (to - from) * 1.0015 ** event.deltaY));
    const begin = Math.min(Math.max(first, at - ((at - from) / (to - from)) * size), last - size);
    this.zoomTo(begin, begin + size);
  }

  private zoomTo(from: number, to: number): void {
    this.view = [from, to];
    this.paint();
    this.showCursor();
  }

  /** Marks the range to loop; an empty one ends it. */
  setRange(a: number, b: number): void {
    const [from, to] = [Math.round(Math.min(a, b)), Math.round(Math.max(a, b))];
    this.clock.range = to > from ? [from, to] : null;
    this.paint();
  }

  /** How far a repair moves each frame; empty without one. */
  setCorrections(corrections: number[]): void {
    this.corrections = corrections;
    this.paint();
  }

  /** Marks the lane of a contact. */
  choose(index: number | null): void {
    const lane = index === null ? null : this.contacts.groups.indexOf(this.contacts.groupOf(this.contacts.items[index]!));
    if (this.chosen === lane) return;
    this.chosen = lane;
    this.paint();
    if (lane !== null && lane < kMaxLanes) this.lanesBox.scrollTop = Math.max(0, (lane - 1) * kLane);
  }

  showCursor(): void {
    const x = this.toX(this.clock.position);
    this.cursor.style.left = `${x}px`;
    this.cursor.hidden = x < -2 || x > this.width + 2;
  }

  private prepare(canvas: HTMLCanvasElement, height: number): CanvasRenderingContext2D {
    const ratio = Math.min(devicePixelRatio, 2);
    canvas.width = this.width * ratio;
    canvas.height = height * ratio;
    const g = canvas.getContext('2d')!;
    g.scale(ratio, ratio);
    return g;
  }

  paint(): void {
    if (this.element.clientWidth === 0) return;
    const style = getComputedStyle(document.documentElement);
    const color: Color = (name) => style.getPropertyValue(name).trim();
    const g = this.prepare(this.strip, kRuler + kStrip);
    this.paintRuler(g, color);
    g.save();
    g.translate(0, kRuler);
    g.beginPath();
    g.rect(0, 0, this.width, kStrip);
    g.clip();
    this.paintSteps(g, color);
    this.paintCorrections(g, color);
    g.restore();
    this.paintLanes(color);
    this.showCursor();
  }

  private paintRuler(g: CanvasRenderingContext2D, color: Color): void {
    const { width } = this;
    const [from, to] = this.view;
    const numbers = this.scene.frame_numbers;
    g.fillStyle = color('--panel');
    g.fillRect(0, 0, width, kRuler);
    if (this.clock.range) {
      const [a, b] = [this.toX(this.clock.range[0] - this.margin), this.toX(this.clock.range[1] + this.margin)];
      g.fillStyle = color('--accent');
      g.globalAlpha = 0.35;
      g.fillRect(a, 0, b - a, kRuler);
      g.globalAlpha = 1;
    }
    g.fillStyle = g.strokeStyle = color('--soft');
    g.font = '10px system-ui, sans-serif';
    g.textBaseline = 'middle';
    const rough = (60 / width) * (to - from);
    const power = 10 ** Math.floor(Math.log10(Math.max(rough, 1)));
    const stride = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= rough) ?? 1;
    g.beginPath();
    for (let k = Math.ceil(from); k <= Math.min(to, this.clock.end); ++k) {
      const main = k % stride === 0;
      if (!main && (to - from) / width > 0.25) continue;
      const x = Math.round(this.toX(k)) + 0.5;
      g.moveTo(x, kRuler);
      g.lineTo(x, main ? kRuler - 7 : kRuler - 3);
      const text = String(numbers[k] ?? k);
      if (main) g.fillText(text, Math.min(x + 3, width - g.measureText(text).width - 2), 7);
    }
    g.stroke();
  }

  /** Hatched until checked; green where it is proven free; red as high as much is inside, frame by frame; pink below where something meets. Gray is only what is not known. */
  private paintSteps(g: CanvasRenderingContext2D, color: Color): void {
    const { width } = this;
    g.fillStyle = color('--stage');
    g.fillRect(0, 0, width, kStrip);
    g.strokeStyle = color('--line');
    g.beginPath();
    for (let x = -kStrip; x < width; x += 6) {
      g.moveTo(x, kStrip);
      g.lineTo(x + kStrip, 0);
    }
    g.stroke();
    const { check } = this;
    const { steps } = check;
    const xOf = (step: number) => this.toX(step / this.clock.substeps - this.margin);
    for (let from = 0, to = 0; from < steps.length; from = to) {
      const name = this.groundOf(from);
      while (to < steps.length && this.groundOf(to) === name) ++to;
      g.fillStyle = color(name);
      g.fillRect(xOf(from), 0, xOf(to) - xOf(from), kStrip);
    }
    this.paintInside(g, color, xOf);
    g.fillStyle = color('--meets');
    for (const step of steps) {
      if (!check.poses && collisionsOf(step) > 0) g.fillRect(xOf(step.number), kStrip - kMeets, Math.max(2, xOf(1) - xOf(0) + 0.4), kMeets);
    }
  }

  private groundOf(number: number): string {
    const { check } = this;
    const step = check.steps[number]!;
    const kind = check.kindOf(step);
    return kind === 'free' ? '--free' : insideOf(step) > 0 ? '--inside' : kind === 'hit' ? '--touched' : '--calm';
  }

  /** A line through the numbers of triangles that are inside in each frame; of poses, a bar for each. */
  private paintInside(g: CanvasRenderingContext2D, color: Color, xOf: (step: number) => number): void {
    const { steps } = this.check;
    const most = Math.max(1, ...steps.map(insideOf));
    const room = kStrip - kMeets - 2;
    const y = (count: number) => kStrip - kMeets - (count === 0 ? 0 : Math.max(3, (count / most) * room));
    g.fillStyle = color('--bar');
    for (const step of steps) {
      if (insideOf(step) === 0) continue;
      const [begin, end] = step.inside.map((count) => count ?? 0) as [number, number];
      const [left, right] = [xOf(step.number), Math.max(xOf(step.number + 1), xOf(step.number) + 2)];
      g.beginPath();
      g.moveTo(left, kStrip - kMeets);
      g.lineTo(left, y(begin));
      g.lineTo(right, y(end));
      g.lineTo(right, kStrip - kMeets);
      g.fill();
    }
  }

  /** A line as high as a repair moves each frame. */
  private paintCorrections(g: CanvasRenderingContext2D, color: Color): void {
    const most = Math.max(...this.corrections);
    if (!(most > 0)) return;
    g.strokeStyle = color('--accent');
    g.lineWidth = 2;
    g.beginPath();
    this.corrections.forEach((correction, k) => g.lineTo(this.toX(k), kStrip - 2 - (correction / most) * (kStrip - 5)));
    g.stroke();
  }

  /** A lane for contacts of the same two parts: each from its first to its last time, as high as it is deep; without a depth, as its curve is long. */
  private paintLanes(color: Color): void {
    const groups = this.contacts.groups.slice(0, kMaxLanes);
    this.lanesBox.hidden = groups.length === 0 || this.clock.frames === 1;
    if (this.lanesBox.hidden) return;
    this.lanes.style.height = `${groups.length * kLane}px`;
    const g = this.prepare(this.lanes, groups.length * kLane);
    const max = { depth: 1e-30, curve: 1e-30 };
    for (const { frames } of this.contacts.items) {
      for (const frame of frames) {
        if (frame.depth !== null) max.depth = Math.max(max.depth, frame.depth);
        else max.curve = Math.max(max.curve, frame.curve_length);
      }
    }
    g.font = '600 10px system-ui, sans-serif';
    g.textBaseline = 'middle';
    const x = (time: number) => this.toX(this.contacts.positionOf(time));
    const wide = Math.max(2, (this.toX(1) - this.toX(0)) * 0.9);
    groups.forEach(({ contacts }, k) => {
      const bottom = (k + 1) * kLane - 1;
      if (k === this.chosen) {
        g.fillStyle = color('--wash');
        g.fillRect(0, bottom + 1 - kLane, this.width, kLane);
      }
      g.fillStyle = color('--line');
      g.fillRect(0, bottom, this.width, 1);
      g.fillStyle = color('--bar');
      for (const contact of contacts) {
        g.fillRect(x(contact.first_time), bottom - 2, Math.max(contact.frames.length > 0 ? 0 : 3, x(contact.last_time) - x(contact.first_time)), 2);
        for (const frame of contact.frames) {
          g.globalAlpha = frame.depth === null ? 0.45 : 1;
          const height = frame.depth === null ? (frame.curve_length / max.curve) * (kLane - 3) : (frame.depth / max.depth) * (kLane - 3);
          g.fillRect(x(frame.time) - wide / 2, bottom - height, wide, height);
        }
        g.globalAlpha = 1;
      }
      const ends = [Math.min(...contacts.map(({ first_time }) => x(first_time))) - wide / 2, Math.max(...contacts.map(({ last_time }) => x(last_time))) + wide / 2] as [number, number];
      this.paintLabel(g, color, contacts[0]!.named ? namesText(contacts[0]!) : `#${contacts[0]!.number}`, ends, bottom - kLane / 2 + 1);
    });
  }

  /** After a contact where there is room, else before it or over its begin. */
  private paintLabel(g: CanvasRenderingContext2D, color: Color, text: string, [first, last]: [number, number], y: number): void {
    const width = g.measureText(text).width;
    const after = Math.max(4, last + 6);
    const x = after + width < this.width ? after : Math.max(4, first - 6 - width);
    g.fillStyle = color('--panel');
    g.fillRect(x - 2, y - 6, width + 4, 12);
    g.fillStyle = color('--ink');
    g.fillText(text, x, y);
  }
}
