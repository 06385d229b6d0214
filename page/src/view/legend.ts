// The legend: the meaning of every color in the picture.
import { css, errorColor, gradient, kBlue, kNothingToProve, kObjectColors, kOrange, kPink, kReasons, kRed, kSky, levelColor, marginColor, timeColor, type Rgb } from '../shared/colors';
import { el } from '../shared/dom';
import { grouped, percent, short } from '../shared/format';
import type { LayerState } from './layers';

/** Numbers of triangles: by reason, and of certified ones by level + 1. */
export interface FaceCounts {
  triangles: number;
  inside: [number, number]; // at the step's begin and its end
  meets: number;
  reasons: number[];
  levels: number[];
}

export function countFaces(parts: Uint8Array[], triangles: number[]): FaceCounts {
  const counts: FaceCounts = { triangles: 0, inside: [0, 0], meets: 0, reasons: new Array<number>(8).fill(0), levels: new Array<number>(129).fill(0) };
  parts.forEach((data, i) => {
    const n = triangles[i]!;
    counts.triangles += n;
    for (let f = 0; f < n; ++f) {
      const marks = data[f]!;
      if (marks & 1) ++counts.meets;
      if (marks & 2) ++counts.inside[0];
      if (marks & 4) ++counts.inside[1];
      const reason = data[n + f]!;
      counts.reasons[Math.min(reason, 7)]! += 1;
      if (reason === 0) counts.levels[((data[2 * n + f]! << 24) >> 24) + 1]! += 1;
    }
  });
  return counts;
}

export interface LegendState {
  layers: LayerState;
  poses: boolean; // steps are poses
  shapes: boolean; // a shape of the model is shown instead of the motion
  end: boolean; // nearer to the step's end than to its begin
  free: boolean; // some step is proven free
  calm: boolean; // some step has no contact but is not proven free
  reasons: string[];
  objects: string[];
  counts: FaceCounts | null;
  boxFrame: number | null;
  chosen: boolean;
  contact: string[] | null; // the sides of the chosen contact
  error: { scale: number; largest: number; rms: number } | null; // or corrections, by the paint
  repaired: boolean; // there is a repaired motion
  remaining: boolean; // what is shown of it touches
}

const swatch = (color: Rgb, className = ''): HTMLElement => el('span', { className: `swatch ${className}`, style: { background: css(color) } });

const item = (mark: HTMLElement, text: string, value = ''): HTMLElement =>
  el('li', {}, mark, el('span', {}, text), value !== '' && el('b', {}, value));

function scale(color: (value: number) => Rgb, title: string, ends: [string, string], value = ''): HTMLElement {
  return el('li', { className: 'scale' }, el('span', { className: 'name' }, title, value !== '' && el('b', {}, value)), el('span', { className: 'bar', style: { background: gradient(color) } }), el('span', { className: 'ends' }, el('span', {}, ends[0]), el('span', {}, ends[1])));
}

function proofItems(state: LegendState): HTMLElement[] {
  const { counts, layers } = state;
  const share = (n: number | undefined) => (counts ? percent((n ?? 0) / Math.max(1, counts.triangles)) : '');
  const items: HTMLElement[] = [];
  if (layers.paint === 'level') {
    const levels = counts ? counts.levels.slice(1).flatMap((n, level) => (n > 0 ? [level] : [])) : [];
    const [low, high] = [levels[0] ?? 0, levels.at(-1) ?? 15];
    items.push(scale((v) => levelColor(Math.round(low + v * (high - low))), 'Proven free, by level of the proof', [`${low} (large patches)`, `${high} (small)`], share(counts?.reasons[0])));
  } else {
    items.push(scale(marginColor, 'Proven free, by margin of the proof', ['0 (barely)', '1 (as built)'], share(counts?.reasons[0])));
  }
  if (!counts || counts.levels[0]! > 0) items.push(item(swatch(kNothingToProve), 'Proven free by boxes and planes alone'));
  state.reasons.forEach((name, k) => {
    const reason = kReasons[name];
    if (k === 0 || !reason || (counts && counts.reasons[k] === 0)) return;
    const line = item(swatch(reason.color), reason.title, share(counts?.reasons[k]));
    line.title = reason.help;
    items.push(line);
  });
  return items;
}

const mark = (kind: string, text: string): HTMLElement => el('span', { className: 'mark' }, el('span', { className: `swatch ${kind}` }), text);

/** The legend's lines for what is switched on. */
export function legendItems(state: LegendState): HTMLElement[] {
  const { layers } = state;
    const items: HTMLElement[] = [];
  if (state.shapes) return [el('li', {}, 'A shape of the model: without motion there are no collisions or proofs of steps')];
  if (layers.source === 'repaired') items.push(el('li', {}, 'The shape is the repaired motion: marks of what was before are left out'));
  if (layers.source === 'prediction') items.push(el('li', {}, 'The shape is the prediction from key points'));
  if (layers.paint === 'plain' && state.objects.length > 1) {
    state.objects.forEach((name, i) => items.push(item(swatch(kObjectColors[i % kObjectColors.length]!), name)));
  }
  const striped = layers.paint !== 'plain';
  if (layers.collisions) items.push(item(swatch(kRed, striped ? 'striped' : ''), state.poses ? 'Inside or crossing' : 'Inside or crossing now', state.counts ? grouped(state.counts.inside[state.end ? 1 : 0]) : ''));
  if (layers.meets && !state.poses) items.push(item(swatch(kPink, striped ? 'striped' : ''), 'Meets in this step', state.counts ? grouped(state.counts.meets) : ''));
  if (layers.contacts) {
    items.push(scale(timeColor, 'Contact points, time of impact', ['0 start of step', '1 end']));
    items.push(el('li', { className: 'marks' }, 'Seen from near:', mark('diamond', 'first'), mark('square', 'last'), mark('later', 'still to come')));
  }
  if (state.remaining) items.push(item(swatch(kRed), 'What still touches: one side'), item(swatch(kBlue), 'What still touches: the other side'));
  if (state.contact) items.push(...state.contact.map((name, k) => item(swatch(k === 0 ? kRed : kBlue), `${name}, inside; pale where it crosses`)), item(el('span', { className: 'swatch curve' }), 'Where the surfaces cross, in the worst frame'));
  if (state.chosen) items.push(item(swatch(kOrange), 'Chosen pair: vertex, first edge or triangle'), item(swatch(kBlue), 'Chosen pair: face, second edge or triangle'));
  if (layers.paint === 'level' || layers.paint === 'margin') items.push(...proofItems(state));
  if ((layers.paint === 'error' || layers.paint === 'correction') && state.error) {
    items.push(scale(errorColor, `${layers.paint === 'error' ? 'Prediction error' : 'Correction'}, mesh units`, ['0', `${short(state.error.scale)} or more`]));
    items.push(el('li', {}, `largest ${short(state.error.largest)}, root mean square ${short(state.error.rms)}`));
  }
  if (layers.keyPoints) items.push(item(swatch(kSky, 'round'), 'Key points'));
  if (layers.boxes && state.boxFrame !== null) items.push(item(swatch(kBlue, 'box'), `Boxes, level ${layers.level}, frame ${state.boxFrame}`));
  const marks = [mark('hit', 'how much is inside'), mark('meets', 'something meets'), mark('open', 'unchecked')];
  if (state.calm) marks.unshift(mark('calm', 'no new contact'));
  if (state.free) marks.unshift(mark('free', 'free'));
  if (state.repaired) marks.push(mark('correction', 'how far repair moves'));
  items.push(el('li', { className: 'marks' }, 'Timeline:', ...marks));
  return items;
}
