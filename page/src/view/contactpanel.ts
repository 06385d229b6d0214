// A card per contact, the worst first.
import { counted, grouped } from '../shared/format';
import { el, setText } from '../shared/dom';
import { unlistedText, worstOf, type Contact } from '../shared/contact';
import { kBetweenNotTested, wordsOf } from '../shared/words';
import type { SceneInfo } from './api';
import type { Check } from './check';
import { framesText, type Contacts } from './contacts';

type Kind = 'all' | 'deep' | 'curve' | 'touch';
const kKinds: [Kind, string][] = [
  ['all', 'all kinds'],
  ['deep', 'with a depth'],
  ['curve', 'without a depth'],
  ['touch', 'only touching'],
];

const kindOf = (contact: Contact): Kind => (contact.frames.length === 0 ? 'touch' : contact.depth === null ? 'curve' : 'deep');
const sidesOf = (contact: Contact): string => contact.sides.map(({ name }) => name).join(' – ');

export class ContactPanel {
  readonly element: HTMLElement;
  private readonly head = el('div', { className: 'head' });
  private readonly note = el('p', { className: 'note' });
  private shown = 0;
  private readonly filters = el('div', { className: 'row filters', hidden: true });
  private readonly sides = el('select', { 'aria-label': 'Between which' });
  private readonly kinds = el('select', { 'aria-label': 'Of which kind' });
  private readonly list = el('div', { className: 'cards', role: 'listbox', 'aria-label': 'Contacts' });
  private cards = new Map<number, HTMLElement>();
  private listed: Contact[] | null = null;

  constructor(
    private readonly scene: SceneInfo,
    private readonly check: Check,
    private readonly contacts: Contacts,
    private readonly choose: (index: number) => void,
  ) {
    for (const [kind, title] of kKinds) this.kinds.append(el('option', { value: kind }, title));
    for (const select of [this.sides, this.kinds]) select.addEventListener('change', () => this.filter());
    this.filters.append(this.sides, this.kinds);
    this.element = el('div', { className: 'panel contacts' }, this.head, this.note, this.filters, this.list);
  }

  show(chosen: number | null): void {
    if (this.contacts.items !== this.listed) this.build();
    else this.showHead();
    for (const [index, card] of this.cards) card.setAttribute('aria-selected', String(index === chosen));
  }

  private showHead(): void {
    const { contacts, check } = this;
    const { step, collisions, colliding } = wordsOf(check.poses);
    const { state, total, unknownFrames } = contacts;
    const notes: string[] = [...contacts.notices];
    let title = 'Contacts';
    if (state === 'known') {
      const hit = check.pairs > 0 || check.startsCrossing;
      if (total === 0 && !hit) title = 'No contacts';
      if (total > 0) title = `${this.shown < this.cards.size ? `${grouped(this.shown)} of ` : ''}${counted(total, 'contact')}, the worst first`;
      if (total > contacts.items.length) notes.push(`The worst ${grouped(contacts.items.length)} are listed; foldproof check --contacts prints all.`);
      if (check.listed < check.pairs) notes.push(unlistedText(check.listed, check.pairs, check.poses));
      if (unknownFrames > 0) notes.push(`What crosses is not known in ${counted(unknownFrames, 'frame')}: too many pairs, or not tested.`);
      if (total === 0 && !hit) notes.push(this.nothing());
    } else if (state === 'none') {
      notes.push(this.scene.settings['mode'] === 'paper' ? 'The statistical mode finds no contacts.' : 'Contacts are found when a check has ended. This one did not reach its end; see the pairs.');
    } else if (check.state === 'running') {
      notes.push(`They are found when all ${step}s are checked. ${check.pairs > 0 ? `The ${colliding} pairs so far are under Pairs.` : `No ${collisions} so far.`}`);
    } else {
      notes.push(check.state === 'done' ? 'Loading…' : 'The program no longer answers, so they are not known.');
    }
    if (check.poses) notes.push(kBetweenNotTested);
    if (this.head.textContent !== title) this.head.replaceChildren(el('strong', {}, title));
    setText(this.note, notes.join(' '));
  }

  /** What it means that nothing was found. */
  private nothing(): string {
    const { check } = this;
    if (check.verdict().kind !== 'free' || check.found().untested !== '') return 'No contacts among what was tested.';
    return check.poses ? 'Nothing crosses in any frame.' : 'Nothing touches or crosses at any time.';
  }

  private build(): void {
    this.listed = this.contacts.items;
    const options = (label: string, names: string[]) => el('optgroup', { label }, ...[...new Set(names)].sort().map((name) => el('option', { value: name }, name)));
    const pairs = this.listed.map(sidesOf);
    this.sides.replaceChildren(
      el('option', { value: '' }, 'between all'),
      options('of', this.listed.flatMap(({ sides }) => sides.map(({ name }) => name))),
      options('between', pairs),
    );
    this.sides.hidden = new Set(pairs).size < 2;
    this.filters.hidden = this.listed.length < 3;
    this.cards = new Map(this.listed.map((contact, index) => [index, this.card(contact, index)]));
    this.filter();
  }

  private filter(): void {
    const shown = [...this.cards].filter(([index]) => {
      const contact = this.listed![index]!;
      const between = ['', sidesOf(contact), ...contact.sides.map(({ name }) => name)];
      return between.includes(this.sides.value) && ['all', kindOf(contact)].includes(this.kinds.value);
    });
    this.shown = shown.length;
    this.list.replaceChildren(...shown.map(([, card]) => card));
    this.showHead();
    if (shown.length === 0 && this.cards.size > 0) this.list.append(el('p', { className: 'note' }, 'None is like that.'));
  }

  private card(contact: Contact, index: number): HTMLElement {
    const worst = worstOf(contact);
    const facts = [framesText(contact)];
    if (worst && contact.frames.length > 1) facts.push(`worst ${worst.time}`);
    if (worst) facts.push(counted(worst.triangles, 'triangle'));
    const notes = [contact.from_start && !this.check.poses && 'from the start', contact.folded && 'folded onto itself', contact.pierces && 'pierces', worst && !contact.pierces && contact.depth === null && 'no depth: its curve encloses no region'].filter((note) => note !== false && note !== undefined);
    return el(
      'button',
      { type: 'button', className: 'contact', role: 'option', 'data-contact': String(contact.number), onclick: () => this.choose(index) },
      el('span', { className: 'number' }, `#${contact.number}`),
      el('b', { className: 'size' }, this.contacts.sizeText(contact)),
      el('strong', {}, this.contacts.title(contact)),
      el('span', { className: 'facts' }, facts.join(' · ')),
      notes.length > 0 && el('small', {}, notes.join(', ')),
    );
  }

  /** Brings a card into sight. */
  reveal(index: number): void {
    this.cards.get(index)?.scrollIntoView({ block: 'nearest' });
  }
}
