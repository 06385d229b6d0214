// A card for contacts of the same two parts, the worst first.
import { counted, grouped } from '../shared/format';
import { el, setText } from '../shared/dom';
import { unlistedText, worstOf, type Contact, type Group } from '../shared/contact';
import { kBetweenNotTested, wordsOf } from '../shared/words';
import type { SceneInfo } from './api';
import type { Check } from './check';
import { framesText, type Contacts } from './contacts';
import type { RepairPanel } from './repair';

const kTimes = 24; // listed on a card

type Kind = 'all' | 'deep' | 'curve' | 'touch';
const kKinds: [Kind, string][] = [
  ['all', 'all kinds'],
  ['deep', 'with a depth'],
  ['curve', 'without a depth'],
  ['touch', 'only touching'],
];

const kindOf = (contact: Contact): Kind => (contact.touching ? 'touch' : contact.depth === null ? 'curve' : 'deep');
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
  private cards = new Map<Group, HTMLElement>();
  private listed: Contact[] | null = null;

  constructor(
    private readonly scene: SceneInfo,
    private readonly check: Check,
    private readonly contacts: Contacts,
    private readonly choose: (index: number) => void,
    private readonly repair: RepairPanel,
  ) {
    for (const [kind, title] of kKinds) this.kinds.append(el('option', { value: kind }, title));
    for (const select of [this.sides, this.kinds]) select.addEventListener('change', () => this.filter());
    this.filters.append(this.sides, this.kinds);
    this.element = el('div', { className: 'panel contacts' }, this.head, this.note, repair.element, this.filters, this.list);
  }

  show(chosen: number | null): void {
    if (this.contacts.items !== this.listed) this.build();
    else this.showHead();
    const group = chosen === null ? null : this.contacts.groupOf(this.contacts.items[chosen]!);
    for (const [each, card] of this.cards) {
      card.setAttribute('aria-selected', String(each === group));
      for (const one of card.querySelectorAll<HTMLElement>('[data-index]')) one.setAttribute('aria-pressed', String(Number(one.dataset['index']) === chosen));
    }
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
      if (total > 0) title = `${this.shown < this.listed!.length ? `${grouped(this.shown)} of ` : ''}${counted(total, 'contact')}, the worst first`;
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
    if (check.answer?.kind !== 'free' || !check.answer.whole) return 'No contacts among what was tested.';
    return check.poses ? 'Nothing crosses in any frame.' : 'Nothing touches or crosses at any time.';
  }

  private build(): void {
    this.listed = this.contacts.items;
    const options = (label: string, names: string[]) => el('optgroup', { label }, ...[...new Set(names)].sort().map((name) => el('option', { value: name }, name)));
    const pairs = this.contacts.groups.map(({ contacts }) => sidesOf(contacts[0]!));
    this.sides.replaceChildren(
      el('option', { value: '' }, 'between all'),
      options('of', this.listed.flatMap(({ sides }) => sides.map(({ name }) => name))),
      options('between', pairs),
    );
    this.sides.hidden = new Set(pairs).size < 2;
    this.filters.hidden = this.contacts.groups.length < 3;
    this.cards = new Map(this.contacts.groups.map((group) => [group, this.card(group)]));
    this.filter();
  }

  private filter(): void {
    const shown = [...this.cards].filter(([{ contacts }]) => {
      const contact = contacts[0]!;
      const between = ['', sidesOf(contact), ...contact.sides.map(({ name }) => name)];
      return between.includes(this.sides.value) && ['all', kindOf(contact)].includes(this.kinds.value);
    });
    this.shown = shown.reduce((sum, [{ contacts }]) => sum + contacts.length, 0);
    this.list.replaceChildren(...shown.map(([, card]) => card));
    this.showHead();
    if (shown.length === 0 && this.cards.size > 0) this.list.append(el('p', { className: 'note' }, 'None is like that.'));
  }

  private card(group: Group): HTMLElement {
    const { contacts, often } = group;
    const contact = contacts[0]!;
    const index = this.contacts.items.indexOf(contact);
    const worst = worstOf(contact);
    const facts = [often || framesText(contact)];
    if (worst && (often || contact.frames.length > 1)) facts.push(`worst in frame ${worst.time}`);
    if (worst) facts.push(counted(worst.triangles, 'triangle'));
    const notes = [contact.from_start && !this.check.poses && 'from the start', contact.folded && 'folded onto itself', contact.pierces && 'pierces'].filter((note) => note !== false && note !== undefined);
    const card = el(
      'div',
      { className: 'contact', role: 'option', tabIndex: 0, 'data-contact': String(contact.number), onclick: () => this.choose(index) },
      el('strong', {}, this.contacts.title(contact)),
      el('b', { className: 'size' }, this.contacts.sizeText(contact)),
      el('span', { className: 'facts' }, facts.join(' · ')),
      notes.length > 0 && el('small', {}, notes.join(', ')),
      contacts.length > 1 && this.occurrences(contacts),
      !this.check.poses && this.contacts.groups.length > 1 && this.repairButton(index, contact),
    );
    card.addEventListener('keydown', (event) => {
      if (event.target !== card || (event.key !== 'Enter' && event.key !== ' ')) return;
      event.preventDefault();
      event.stopPropagation();
      this.choose(index);
    });
    return card;
  }

  /** Repairs this and nothing else. */
  private repairButton(index: number, contact: Contact): HTMLElement {
    const begin = (event: Event) => {
      event.stopPropagation();
      this.repair.begin({ index, title: this.contacts.title(contact) });
    };
    return el('button', { className: 'small alone', type: 'button', title: 'Other contacts stay', onclick: begin }, 'Repair only this');
  }

  /** A button for each time that two parts meet, in order. */
  private occurrences(contacts: Contact[]): HTMLElement {
    const box = el('span', { className: 'times' });
    const shown = [...contacts].sort((a, b) => a.first_time - b.first_time).slice(0, kTimes);
    for (const contact of shown) {
      const index = this.contacts.items.indexOf(contact);
      const choose = (event: Event) => {
        event.stopPropagation();
        this.choose(index);
      };
      box.append(el('button', { type: 'button', 'data-index': String(index), title: `${framesText(contact)}: ${this.contacts.sizeText(contact)}`, onclick: choose }, framesText(contact).replace(/^frames? /, '')));
    }
    if (contacts.length > kTimes) box.append(el('small', {}, `and ${contacts.length - kTimes} more`));
    return box;
  }

  /** Brings a card into sight. */
  reveal(index: number): void {
    this.cards.get(this.contacts.groupOf(this.contacts.items[index]!))?.scrollIntoView({ block: 'nearest' });
  }
}
