// What goes through what: a lane for each contact over the frames, and a card with its picture.
import { namesText, placeText, touchText, worstOf, type Contact } from '../shared/contact';
import { el } from '../shared/dom';
import { counted, grouped, short } from '../shared/format';

/** A contact and its picture. */
export interface PicturedContact extends Contact {
  picture?: string | null;
}

/** How contacts are written, and the frames at both ends. */
export interface Scale {
  unit: string;
  poses: boolean; // with no motion between them
  single: boolean; // only one frame
  unknownFrames: number; // of which is not known what crosses
  low: number;
  high: number;
}

const kLaneLimit = 30;

const time = (value: number): string => String(Number(value.toPrecision(6)));
const length = (value: number, { unit }: Scale): string => (unit ? `${short(value)} ${unit}` : short(value));

function when({ frames, first_time, last_time }: Contact): string {
  if (frames.length === 0) return first_time === last_time ? `time ${time(first_time)}` : `times ${time(first_time)} to ${time(last_time)}`;
  const [first, last] = [frames[0]!.time, frames.at(-1)!.time];
  return first === last ? `frame ${time(first)}` : `frames ${time(first)} to ${time(last)}`;
}

/** How large it is, in a few words. */
function size(contact: Contact, scale: Scale): string {
  const frame = worstOf(contact);
  if (!frame) return touchText(scale.unknownFrames, scale.single);
  return frame.depth === null ? `crosses along ${length(frame.curve_length, scale)}` : `${length(frame.depth, scale)} deep`;
}

/** The sides in the colors of the picture. */
function title(contact: Contact): HTMLElement {
  const [a, b] = [contact.sides[0]!, contact.sides[1]!];
  const side = (name: string, color: string) => el('span', { className: 'side' }, el('span', { className: 'swatch', style: { background: color } }), name);
  const both = a.name === b.name ? [el('span', {}, namesText(contact))] : [side(a.name, 'var(--side-a)'), side(b.name, 'var(--side-b)')];
  return el('h3', {}, el('span', { className: 'number' }, `#${contact.number}`), ...both);
}

function facts(contact: Contact, scale: Scale): [string, string][] {
  const frame = worstOf(contact);
  const rows: [string, string][] = [[contact.frames.length > 0 ? 'crosses in' : 'touches at', when(contact)]];
  if (frame) {
    rows.push(['worst frame', `${time(frame.time)}: ${counted(frame.triangles, 'triangle')}`]);
    rows.push(frame.depth === null ? ['depth', 'none: no region lies inside'] : ['depth', length(frame.depth, scale)]);
    rows.push(['curves', `${length(frame.curve_length, scale)} long${frame.closed ? ', closed' : ', open'}`]);
  }
  rows.push(['place', placeText(contact)]);
  if (contact.pairs > 0) rows.push(['new contacts', counted(contact.pairs, 'pair')]);
  const notes = [contact.from_start && !scale.poses && 'there from the start', !contact.healed && !scale.poses && 'there at the end', contact.folded && 'one piece folded onto itself', contact.pierces && 'a line or point pierces faces'].filter(Boolean);
  if (notes.length > 0) rows.push(['', notes.join('; ')]);
  return rows;
}

function card(contact: PicturedContact, scale: Scale): HTMLElement {
  const list = el('dl', {});
  for (const [key, value] of facts(contact, scale)) list.append(el('dt', {}, key), el('dd', {}, value));
  const pictured = contact.picture ? el('img', { src: contact.picture, alt: `Contact ${contact.number}: ${namesText(contact)}, ${when(contact)}` }) : null;
  return el('article', { className: 'contact', id: `contact-${contact.number}` }, el('header', {}, title(contact), el('b', {}, size(contact, scale))), pictured, list);
}

/** Where in the motion each contact is, the darker the deeper. */
function lanes(contacts: Contact[], scale: Scale): HTMLElement {
  const box = el('div', { className: 'lanes' });
  const span = Math.max(scale.high - scale.low, 1);
  const at = (value: number) => `${(100 * (value - scale.low)) / span}%`;
  const deepest = Math.max(...contacts.map(({ depth }) => depth ?? 0));
  for (const contact of contacts.slice(0, kLaneLimit)) {
    const from = Math.min(contact.first_time, contact.frames[0]?.time ?? contact.first_time);
    const share = deepest > 0 ? (contact.depth ?? 0) / deepest : 0;
    const bar = el('i', { className: 'bar', style: { left: at(from), width: `${(100 * (contact.last_time - from)) / span}%`, opacity: String(0.35 + 0.65 * share) } });
    const worst = contact.worst === null ? null : el('i', { className: 'worst', style: { left: at(contact.worst) } });
    const text = `Contact ${contact.number}: ${namesText(contact)}, ${when(contact)}, ${size(contact, scale)}`;
    box.append(el('a', { href: `#contact-${contact.number}`, title: text, 'aria-label': text }, el('span', { className: 'label' }, `#${contact.number}`), el('span', { className: 'track' }, bar, worst)));
  }
  box.append(el('div', { className: 'axis' }, el('span', {}, `frame ${time(scale.low)}`), el('span', {}, time(scale.high))));
  return box;
}

/** Contacts without a picture, in a table. */
function rest(contacts: Contact[], scale: Scale): HTMLElement | null {
  if (contacts.length === 0) return null;
  const row = (contact: Contact) => el('tr', { id: `contact-${contact.number}` }, el('td', { className: 'number' }, `#${contact.number}`), el('td', {}, namesText(contact)), el('td', {}, when(contact)), el('td', { className: 'number' }, size(contact, scale)));
  return el('div', { className: 'wide' }, el('table', {}, el('tbody', {}, ...contacts.map(row))));
}

/** All contacts, the worst first; null if there are none. `count`: of all, also those that are not listed. `unlisted`: what they leave out, if anything. */
export function contactsSection(contacts: PicturedContact[], count: number, unlisted: string | undefined, scale: Scale): HTMLElement | null {
  if (contacts.length === 0) return null;
  const pictured = contacts.filter(({ picture }) => picture);
  const cards = pictured.length > 0 ? pictured : contacts.slice(0, 1);
  const others = contacts.filter((contact) => !cards.includes(contact));
  const more = count - contacts.length;
  return el(
    'section',
    { className: 'contacts' },
    el('h2', {}, count === 1 ? 'The contact' : `${grouped(count)} contacts, the worst first`),
    unlisted && el('p', { className: 'note' }, unlisted),
    scale.high > scale.low ? lanes(contacts, scale) : null,
    el('div', { className: 'cards' }, ...cards.map((contact) => card(contact, scale))),
    rest(others, scale),
    more > 0 ? el('p', { className: 'note' }, `${counted(more, 'more contact')} in the table of foldproof check --contacts-csv.`) : null,
  );
}
