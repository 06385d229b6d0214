// Switches for what is shown; a disabled switch says why.
import { append, el, setText } from '../shared/dom';
import { isStatic } from '../shared/words';
import type { SceneInfo } from './api';
import type { Paint } from './surface';

export type ShapeSource = 'motion' | 'prediction' | 'repaired';

export interface LayerState {
  paint: Paint;
  collisions: boolean;
  meets: boolean;
  contacts: boolean;
  keyPoints: boolean;
  boxes: boolean;
  level: number;
  edges: boolean;
  seeThrough: boolean;
  source: ShapeSource;
  visible: boolean[];
}

type Switch = 'collisions' | 'meets' | 'contacts' | 'keyPoints' | 'boxes' | 'edges' | 'seeThrough';

const kSwitches: [Switch, string, string, string][] = [
  ['collisions', 'Inside now', 'C', 'triangles that cross others or are inside them at this time, red; hidden ones shine through'],
  ['meets', 'Meets in this step', 'M', 'triangles that meet others during the step, pink'],
  ['contacts', 'Contact points', 'T', 'where pairs touch, colored by time of impact; seen from near'],
  ['keyPoints', 'Key points', 'K', 'the vertices that determine the shape'],
  ['boxes', 'Boxes of the hierarchy', 'B', 'the bounding boxes that the broad phase tests'],
  ['edges', 'Edges of triangles', 'E', ''],
  ['seeThrough', 'See through', 'X', 'what is red or pink stays solid'],
];

/** Those of poses: no pose follows from the first, and nothing in it moves into contact. */
const kPoseSwitches: typeof kSwitches = [
  ['collisions', 'Inside', 'C', 'triangles that cross others or are inside them in this frame, red; hidden ones shine through'],
  ...kSwitches.filter(([name]) => name === 'keyPoints' || name === 'boxes' || name === 'edges'),
  ['seeThrough', 'See through', 'X', 'what is red stays solid'],
];

const kPaints: [Paint, string, string][] = [
  ['plain', 'Plain', 'clay'],
  ['level', 'Proof: level', 'proven free, by the level of the hierarchy that proved it; others by reason'],
  ['margin', 'Proof: margin', 'proven free, by the slack of the proof; others by reason'],
  ['error', 'Prediction error', 'distance between the surface and what key points predict'],
  ['correction', 'Correction', 'how far the repair moved the surface'],
];

const kNoRepair = 'Needs a repair: see under Contacts.';

/** Why layers are unavailable; empty if they are available. */
export function whyNot(scene: SceneInfo): { keyPoints: string; error: string } {
  const model = scene.objects.some((object) => object.model);
  const learned = scene.objects.some((object) => (object.model?.key_points.length ?? 0) > 0);
  const missing = model ? 'The model has learned no key points; train one with foldproof train.' : 'Needs a model: start with --model FILE (foldproof train makes one).';
  return {
    keyPoints: learned ? '' : missing,
    error: learned ? '' : missing,
  };
}

export class LayerPanel {
  readonly element = el('div', { className: 'panel layers' });
  readonly state: LayerState;
  private readonly paints = new Map<Paint, HTMLInputElement>();
  private readonly shapes = new Map<ShapeSource, HTMLInputElement>();
  private readonly switches = new Map<Switch, HTMLInputElement>();
  private readonly level: HTMLInputElement;
  private readonly levelText = el('output');
  private readonly poses: boolean;

  constructor(
    private readonly scene: SceneInfo,
    private readonly changed: () => void,
  ) {
    this.poses = isStatic(scene.settings);
    const deepest = Math.max(0, ...scene.objects.map((object) => object.levels));
    this.state = {
      paint: 'plain',
      collisions: true,
      meets: !this.poses,
      contacts: !this.poses,
      keyPoints: false,
      boxes: false,
      level: Math.min(4, deepest),
      edges: false,
      seeThrough: false,
      source: 'motion',
      visible: scene.objects.map(() => true),
    };
    this.level = el('input', { type: 'range', min: '0', max: String(deepest), step: '1', value: String(this.state.level), 'aria-label': 'Level of the boxes' });
    this.level.addEventListener('input', () => this.setLevel(Number(this.level.value)));
    this.build();
  }

  private build(): void {
    const why = whyNot(this.scene);
    const paints = el('fieldset', {}, el('legend', {}, 'Color of the surface'));
    for (const [paint, title, help] of kPaints) {
      if (paint === 'correction' && this.poses) continue; // only motions are repaired
      const reason = paint === 'error' ? why.error : paint === 'correction' ? kNoRepair : '';
      const input = el('input', { type: 'radio', name: 'paint', value: paint, checked: paint === 'plain', disabled: reason !== '' });
      input.addEventListener('change', () => this.setPaint(paint));
      this.paints.set(paint, input);
      paints.append(this.line(input, title, reason || help, reason !== ''));
    }
    const marks = el('fieldset', {}, el('legend', {}, 'Shown'));
    for (const [name, title, key, help] of this.poses ? kPoseSwitches : kSwitches) {
      const reason = name === 'keyPoints' ? why.keyPoints : '';
      const input = el('input', { type: 'checkbox', checked: this.state[name], disabled: reason !== '', 'data-layer': name });
      input.addEventListener('change', () => this.set(name, input.checked));
      this.switches.set(name, input);
      marks.append(this.line(input, title, reason || help, reason !== '', key));
      if (name === 'boxes') marks.append(el('label', { className: 'level' }, 'Level ', this.level, this.levelText));
    }
    append(this.element, paints, marks, this.sources(why.error), this.objects());
    setText(this.levelText, String(this.state.level));
  }

  private line(input: HTMLInputElement, title: string, help: string, off: boolean, key = ''): HTMLElement {
    return el('label', { className: off ? 'line off' : 'line' }, input, el('span', {}, title, key !== '' && el('kbd', {}, key), help !== '' && el('small', {}, help)));
  }

  private sources(reason: string): HTMLElement {
    const box = el('fieldset', {}, el('legend', {}, 'Shape'));
    const all: [ShapeSource, string, string][] = [
      ['motion', this.poses ? 'The frames' : 'The motion', ''],
      ['prediction', 'Its prediction from key points', reason],
      ...(this.poses ? [] : [['repaired', 'The repaired motion', kNoRepair] as [ShapeSource, string, string]]),
    ];
    for (const [source, title, why] of all) {
      const input = el('input', { type: 'radio', name: 'source', value: source, checked: source === 'motion', disabled: why !== '' });
      input.addEventListener('change', () => this.setSource(source));
      this.shapes.set(source, input);
      box.append(this.line(input, title, why, why !== ''));
    }
    return box;
  }

  private objects(): HTMLElement | null {
    if (this.scene.objects.length < 2) return null;
    const box = el('fieldset', {}, el('legend', {}, 'Objects'));
    this.scene.objects.forEach((object, i) => {
      const input = el('input', { type: 'checkbox', checked: true });
      input.addEventListener('change', () => {
        this.state.visible[i] = input.checked;
        this.changed();
      });
      box.append(this.line(input, object.name, `${object.triangles.toLocaleString('en-US')} triangles`, false));
    });
    return box;
  }

  set(name: Switch, value: boolean): void {
    const input = this.switches.get(name);
    if (!input || input.disabled) return;
    input.checked = value;
    this.state[name] = value;
    this.changed();
  }

  toggle(name: Switch): void {
    this.set(name, !this.state[name]);
  }

  setPaint(paint: Paint): void {
    const input = this.paints.get(paint)!;
    if (input.disabled) return;
    input.checked = true;
    this.state.paint = paint;
    this.changed();
  }

  setSource(source: ShapeSource): void {
    this.shapes.get(source)!.checked = true;
    this.state.source = source;
    this.changed();
  }

  /** There is a repaired motion, or there is none any more. */
  offerRepaired(exists: boolean): void {
    const inputs = [this.paints.get('correction'), this.shapes.get('repaired')];
    for (const input of inputs) {
      if (!input) continue;
      const line = input.closest('.line')!;
      input.disabled = !exists;
      line.classList.toggle('off', !exists);
      setText(line.querySelector('small')!, exists ? (input === inputs[0] ? 'how far the repair moved the surface' : 'F shows it, or what was before') : kNoRepair);
    }
    if (exists) return;
    if (this.state.paint === 'correction') this.setPaint('plain');
    if (this.state.source === 'repaired') this.setSource('motion');
  }

  /** Switches to the next available surface color. */
  cyclePaint(): void {
    const usable = kPaints.map(([paint]) => paint).filter((paint) => this.paints.get(paint)?.disabled === false);
    this.setPaint(usable[(usable.indexOf(this.state.paint) + 1) % usable.length]!);
  }

  setLevel(level: number): void {
    this.level.value = String(level);
    this.state.level = Number(this.level.value);
    setText(this.levelText, this.level.value);
    this.changed();
  }
}
