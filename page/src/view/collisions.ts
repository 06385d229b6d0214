// The list of pairs. Only visible rows exist.
import { css, timeColor } from '../shared/colors';
import { append, el, icon, notesOfReaders, setText } from '../shared/dom';
import { counted, grouped, toiText } from '../shared/format';
import { collisionsOf, stepText, type Step } from '../shared/steps';
import { startText, stoppedText } from '../shared/verdict';
import { capital, kBetweenNotTested, kStartNotTested, wordsOf } from '../shared/words';
import type { Pair, SceneInfo } from './api';
import { copyButton } from './copy';
import type { Check, PairsOfStep } from './check';

const kRowHeight = 44;
const kNone: Pair[] = [];
const kKinds = { vf: ['VF', 'vertex–face'], ee: ['EE', 'edge–edge'], tt: ['TT', 'crossing triangles'] } as const;

/** Which of the pairs are not marked, or not in the list. */
function leftOut(marked: number, total: number, pairs: PairsOfStep | undefined): string[] {
  const parts: string[] = [];
  if (marked < total) parts.push(`Only ${grouped(marked)} ${marked === 1 ? 'is' : 'are'} marked; --limit N marks more.`);
  if (pairs?.complete && pairs.items.length < marked) parts.push(`The first ${grouped(pairs.items.length)} are listed; foldproof check --csv writes all.`);
  return parts;
}

export class CollisionPanel {
  readonly element: HTMLElement;
  private readonly start: HTMLButtonElement;
  private readonly startText = el('span', {});
  private readonly head = el('div', { className: 'head' });
  private readonly note = el('p', { className: 'note' });
  private readonly list = el('div', { className: 'pairs', role: 'listbox', tabIndex: 0 });
  private readonly space = el('div', { className: 'space' });
  private readonly rows: HTMLElement[] = [];
  private crossings = kNone;
  private contacts = kNone;
  private items: Pair[] = []; // both, as listed
  private chosen: Pair | null = null;

  constructor(
    private readonly scene: SceneInfo,
    private readonly check: Check,
    private readonly choose: (pair: Pair) => void,
    go: (direction: 1 | -1) => void,
    goToStart: () => void,
  ) {
    this.start = el('button', { className: 'start', type: 'button', title: 'Go to the start', onclick: goToStart }, el('span', { className: 'swatch crossing' }), this.startText);
    const { step, collisions, colliding, orStart } = wordsOf(check.poses);
    this.list.setAttribute('aria-label', `${capital(colliding)} pairs`);
    const button = (path: string, title: string, direction: 1 | -1) =>
      el('button', { className: 'small', type: 'button', title, onclick: () => go(direction) }, icon(path), direction < 0 ? 'Previous' : 'Next');
    this.list.append(this.space);
    this.list.addEventListener('scroll', () => this.fill(), { passive: true });
    this.list.addEventListener('keydown', (event) => this.key(event));
    new ResizeObserver(() => this.fill()).observe(this.list);
    this.element = el(
      'div',
      { className: 'panel collisions' },
      !check.poses && this.start,
      this.head,
      el('div', { className: 'row' }, button('M15 5l-8 7 8 7z', `Previous ${step} with ${collisions}${orStart} (P)`, -1), button('M9 5l8 7-8 7z', `Next ${step} with ${collisions} (N)`, 1)),
      this.note,
      check.poses && el('p', { className: 'note' }, kBetweenNotTested),
      ...notesOfReaders(scene.objects),
      this.list,
    );
  }

  /** Shows a step; `step` is undefined while it is not checked. `crossings`: those of the first frame, if they are listed. */
  show(step: Step | undefined, pairs: PairsOfStep | undefined, crossings: PairsOfStep | undefined): void {
    if (!this.check.poses) this.showStart(crossings);
    if (step) this.showStep(step, pairs);
    else this.say(this.check.state === 'running' ? 'Not checked yet' : 'Not checked', '', this.check.state === 'running' ? '' : `${stoppedText(this.check.found())}.`);
    const kind = step ? this.check.kindOf(step) : 'open';
    this.head.dataset['kind'] = kind;
    this.listPairs(crossings?.items ?? kNone, step && pairs?.step === step.number ? pairs.items : kNone);
  }

  private showStart(crossings: PairsOfStep | undefined): void {
    const { check } = this;
    const first = this.scene.frame_numbers[0] ?? 0;
    this.start.classList.toggle('hit', check.startsCrossing);
    this.start.disabled = !check.startsCrossing;
    if (check.start) setText(this.startText, [`${startText(check.start, this.scene.frames === 1)}.`, ...leftOut(check.start.listed, check.start.crossings, crossings)].join(' '));
    else if (this.scene.settings['steps_only'] === true) setText(this.startText, `${capital(kStartNotTested)}.`);
    else setText(this.startText, check.state === 'running' ? `Frame ${first} is not checked yet.` : `Frame ${first} was not checked.`);
  }

  private showStep(step: Step, pairs: PairsOfStep | undefined): void {
    const count = collisionsOf(step);
    const { poses } = this.check;
    const single = this.scene.frames === 1 && !poses;
    const where = stepText(step, this.scene.substeps);
    const kind = this.check.kindOf(step);
    if (kind === 'free') this.say(single || poses ? 'Nothing crosses' : 'Nothing is inside and nothing meets', where, '');
    else if (count > 0) this.say(single ? counted(count, 'pair in contact', 'pairs in contact') : counted(count, `${wordsOf(poses).colliding} pair`), where, this.details(step, pairs));
    else this.say(single ? 'No other contact' : 'No new contact in this step', where, single ? '' : kind === 'hit' ? 'What is inside stays there: see Contacts.' : 'It is not known whether parts are inside each other.');
  }

  private listPairs(crossings: Pair[], contacts: Pair[]): void {
    const length = crossings.length + contacts.length;
    const changed = crossings !== this.crossings || contacts !== this.contacts || length !== this.items.length;
    if (!changed) return;
    [this.crossings, this.contacts] = [crossings, contacts];
    this.items = crossings.length === 0 ? [...contacts] : [...crossings, ...contacts];
    this.space.style.height = `${length * kRowHeight}px`;
    this.fill();
  }

  private details(step: Step, pairs: PairsOfStep | undefined): string {
    const left = leftOut(step.listed, collisionsOf(step), pairs);
    if (this.check.poses) return left.join(' ');
    if (this.scene.frames === 1) return 'Closer than or as close as the thickness, without moving.';
    const undecided = step.undecided > 0 ? `, ${grouped(step.undecided)} of them undecided and counted as collisions` : '';
    return [`First contact ${toiText(step.toi)} of the way. ${counted(step.vertex_face, 'vertex–face pair')}, ${grouped(step.edge_edge)} edge–edge${undecided}.`, ...left].join(' ');
  }

  private say(title: string, where: string, note: string): void {
    const text = `${title}\n${where}`;
    if (this.head.dataset['text'] !== text) {
      this.head.dataset['text'] = text;
      this.head.replaceChildren(el('strong', {}, title), el('span', {}, where));
    }
    setText(this.note, note);
  }

  private name(object: number): string {
    return this.scene.objects.length > 1 ? ` of ${this.scene.objects[object]?.name ?? object}` : '';
  }

  private describe(pair: Pair): [string, string] {
    if (pair.kind === 'tt') return [`triangle ${pair.a[0]}${this.name(pair.object_a)}`, `triangle ${pair.b[0]}${this.name(pair.object_b)}`];
    if (pair.kind === 'vf') return [`vertex ${pair.a[0]}${this.name(pair.object_a)}`, `face ${pair.b[0]}${this.name(pair.object_b)}`];
    return [`edge ${pair.a[0]}–${pair.a[1]}${this.name(pair.object_a)}`, `edge ${pair.b[0]}–${pair.b[1]}${this.name(pair.object_b)}`];
  }

  private fill(): void {
    const first = Math.floor(this.list.scrollTop / kRowHeight);
    const inSight = Math.ceil(this.list.clientHeight / kRowHeight) + 1;
    while (this.rows.length < inSight) {
      const row = el('button', { type: 'button', className: 'pair', role: 'option', tabIndex: -1 });
      row.addEventListener('click', () => this.pick(Number(row.dataset['index'])));
      this.rows.push(row);
      this.space.append(row);
    }
    this.rows.forEach((row, k) => {
      const index = first + k;
      const pair = k < inSight ? this.items[index] : undefined;
      row.hidden = !pair;
      if (!pair) return;
      row.style.top = `${index * kRowHeight}px`;
      row.dataset['index'] = String(index);
      row.setAttribute('aria-selected', String(pair === this.chosen));
      const [a, b] = this.describe(pair);
      row.replaceChildren(
        el('span', { className: `kind ${pair.kind}`, title: kKinds[pair.kind][1] }, kKinds[pair.kind][0]),
        el('span', { className: 'what' }, el('span', {}, a), el('span', {}, b)),
        ...(pair === this.chosen ? [copyButton(`${a}, ${b}`)] : []),
        this.when(pair),
      );
    });
  }

  /** When a pair of a motion touches; pairs of a pose have no time. */
  private when(pair: Pair): HTMLElement {
    const time = el('span', { className: 'toi' });
    if (pair.kind !== 'tt') append(time, el('span', { className: 'swatch round', style: { background: css(timeColor(pair.toi)) } }), toiText(pair.toi), pair.answer === 'undecided' && el('small', {}, 'undecided'));
    else if (!this.check.poses) append(time, el('span', { className: 'swatch crossing' }), 'start');
    return time;
  }

  private pick(index: number): void {
    const pair = this.items[index];
    if (!pair) return;
    this.chosen = pair;
    this.fill();
    this.choose(pair);
  }

  /** Picks the next or previous pair in the list. */
  move(by: number): void {
    const at = this.chosen ? this.items.indexOf(this.chosen) : -1;
    const index = Math.min(Math.max(0, at + by), this.items.length - 1);
    const top = index * kRowHeight;
    if (top < this.list.scrollTop) this.list.scrollTop = top;
    if (top + kRowHeight > this.list.scrollTop + this.list.clientHeight) this.list.scrollTop = top + kRowHeight - this.list.clientHeight;
    this.pick(index);
  }

  private key(event: KeyboardEvent): void {
    if (event.key !== 'ArrowDown' && event.key !== 'ArrowUp') return;
    event.preventDefault();
    event.stopPropagation();
    this.move(event.key === 'ArrowDown' ? 1 : -1);
  }
}
