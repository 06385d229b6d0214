// The list of pairs. Only the rows in sight exist.
import { css, timeColour } from '../shared/colours';
import { el, icon, setText } from '../shared/dom';
import { counted, grouped, toiText } from '../shared/format';
import { collisionsOf, placeText, type Step } from '../shared/steps';
import type { Pair, SceneInfo } from './api';
import type { PairsOfStep } from './check';

const kRowHeight = 44;

export class CollisionPanel {
  readonly element: HTMLElement;
  private readonly head = el('div', { className: 'head' });
  private readonly note = el('p', { className: 'note' });
  private readonly list = el('div', { className: 'pairs', role: 'listbox', 'aria-label': 'Colliding pairs', tabIndex: 0 });
  private readonly space = el('div', { className: 'space' });
  private readonly rows: HTMLElement[] = [];
  private items: Pair[] = [];
  private chosen: Pair | null = null;

  constructor(
    private readonly scene: SceneInfo,
    private readonly choose: (pair: Pair) => void,
    go: (direction: 1 | -1) => void,
  ) {
    const button = (path: string, title: string, direction: 1 | -1) =>
      el('button', { className: 'small', type: 'button', title, onclick: () => go(direction) }, icon(path), direction < 0 ? 'Previous' : 'Next');
    this.list.append(this.space);
    this.list.addEventListener('scroll', () => this.fill(), { passive: true });
    this.list.addEventListener('keydown', (event) => this.key(event));
    new ResizeObserver(() => this.fill()).observe(this.list);
    this.element = el(
      'div',
      { className: 'panel collisions' },
      this.head,
      el('div', { className: 'row' }, button('M15 5l-8 7 8 7z', 'Previous step with collisions (P)', -1), button('M9 5l8 7-8 7z', 'Next step with collisions (N)', 1)),
      this.note,
      this.list,
    );
  }

  /** What is known of the present step; `step` is undefined while it is not checked. */
  show(step: Step | undefined, pairs: PairsOfStep | undefined, unchecked: string): void {
    const items = step && pairs?.step === step.number ? pairs.items : [];
    if (!step) {
      this.say(unchecked, '', '');
    } else {
      const count = collisionsOf(step);
      const place = placeText(step, this.scene.substeps);
      if (count === 0) this.say('Free of collisions', place, '');
      else this.say(counted(count, 'colliding pair'), place, this.details(step, pairs));
      this.head.classList.toggle('hit', count > 0);
    }
    this.head.classList.toggle('open', !step);
    const changed = items !== this.items || this.space.style.height !== `${items.length * kRowHeight}px`;
    this.items = items;
    if (!changed) return;
    this.space.style.height = `${items.length * kRowHeight}px`;
    this.fill();
  }

  private details(step: Step, pairs: PairsOfStep | undefined): string {
    const parts = [`First contact ${toiText(step.toi)} of the way. ${counted(step.vertex_face, 'vertex–face pair')}, ${grouped(step.edge_edge)} edge–edge`];
    if (step.undecided > 0) parts.push(`, ${grouped(step.undecided)} of them undecided and counted as collisions`);
    parts.push('. ');
    if (step.listed < collisionsOf(step)) parts.push(`Only ${grouped(step.listed)} are marked; --limit N marks more. `);
    if (pairs?.complete && pairs.items.length < step.listed) parts.push(`The first ${grouped(pairs.items.length)} are listed; foldproof check --csv writes all. `);
    return parts.join('');
  }

  private say(title: string, place: string, note: string): void {
    const text = `${title}\n${place}`;
    if (this.head.dataset['text'] !== text) {
      this.head.dataset['text'] = text;
      this.head.replaceChildren(el('strong', {}, title), el('span', {}, place));
    }
    setText(this.note, note);
  }

  private name(object: number): string {
    return this.scene.objects.length > 1 ? ` of ${this.scene.objects[object]?.name ?? object}` : '';
  }

  private describe(pair: Pair): [string, string] {
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
        el('span', { className: `kind ${pair.kind}`, title: pair.kind === 'vf' ? 'vertex–face' : 'edge–edge' }, pair.kind === 'vf' ? 'VF' : 'EE'),
        el('span', { className: 'what' }, el('span', {}, a), el('span', {}, b)),
        el('span', { className: 'toi' }, el('span', { className: 'swatch round', style: { background: css(timeColour(pair.toi)) } }), toiText(pair.toi), pair.answer === 'undecided' && el('small', {}, 'undecided')),
      );
    });
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
