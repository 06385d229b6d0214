// What goes through what: a lane for each contact over the frames, and a card with its picture.
import { depthText, groupsOf, namesText, placeText, touchText, worstOf, type Contact, type Group } from '../shared/contact';
import { el } from '../shared/dom';
import { counted, grouped, lengthText } from '../shared/format';

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
const kOccurrences = 12; // listed on a card

const time = (value: number): string => String(Number(value.toPrecision(6)));

export function framesText(contacts: Contact[]): string {
  const crossing = contacts.filter(({ frames }) => frames.length > 0);
  const [noun, spans] = crossing.length > 0 ? ['frame', crossing.map(({ frames }) => [frames[0]!.time, frames.at(-1)!.time])] : ['time', contacts.map(({ first_time, last_time }) => [first_time, last_time])];
  const [first, last] = [Math.min(...spans.map(([from]) => from!)), Math.max(...spans.map(([, to]) => to!))];
  return first === last ? `${noun} ${time(first)}` : `${noun}s ${time(first)} to ${time(last)}`;
}

/** How large it is, in a few words. */
export function sizeText(contact: Contact, scale: Scale): string {
  const frame = worstOf(contact);
  return frame ? depthText(frame, scale.unit) : touchText(scale.unknownFrames, scale.single);
}

/** The sides in the colors of the picture. */
export function title(contact: Contact): HTMLElement {
  const [a, b] = [contact.sides[0]!, contact.sides[1]!];
  const side = (name: string, color: string) => el('span', { className: 'side' }, el('span', { className: 'swatch', style: { background: color } }), name);
  const both = a.name === b.name ? [el('span', {}, namesText(contact))] : [side(a.name, 'var(--side-a)'), side(b.name, 'var(--side-b)')];
  return el('h3', {}, ...both);
}

function facts({ contacts }: Group, scale: Scale): [string, string][] {
  const contact = contacts[0]!;
  const frame = worstOf(contact);
  const rows: [string, string][] = [[contact.frames.length > 0 ? 'crosses in' : 'touches at', framesText(contacts)]];
  if (contacts.length > 1) rows.push(['in all', contacts.map((each) => `${framesText([each])}: ${sizeText(each, scale)}`).slice(0, kOccurrences).join('; ') + (contacts.length > kOccurrences ? `; and ${contacts.length - kOccurrences} more` : '')]);
  if (frame) {
    rows.push(['worst frame', `${time(frame.time)}: ${counted(frame.triangles, 'triangle')}`]);
    rows.push(['curves', `${lengthText(frame.curve_length, scale.unit)} long${frame.closed ? ', closed' : ', open'}`]);
  }
  rows.push(['place', placeText(contact)]);
  if (contact.pairs > 0) rows.push(['new contacts', counted(contact.pairs, 'pair')]);
  const notes = [contact.from_start && !scale.poses && 'there from the start', !contact.healed && !scale.poses && 'there at the end', contact.folded && 'one piece folded onto itself', contact.pierces && 'a line or point pierces faces'].filter(Boolean);
  if (notes.length > 0) rows.push(['', notes.join('; ')]);
  return rows;
}

function card(group: Group, scale: Scale): HTMLElement {
  const contact = group.contacts[0]! as PicturedContact;
  const list = el('dl', {});
  for (const [key, value] of facts(group, scale)) list.append(el('dt', {}, key), el('dd', {}, value));
  const pictured = contact.picture ? el('img', { src: contact.picture, alt: `${namesText(contact)}, ${framesText([contact])}` }) : null;
  return el('article', { className: 'contact', id: `contact-${contact.number}` }, el('header', {}, title(contact), el('b', {}, [group.often, sizeText(contact, scale)].filter(Boolean).join(', '))), pictured, list);
}

/** Where in the motion the contacts of each group are, the darker the deeper. */
function lanes(groups: Group[], scale: Scale): HTMLElement {
  const box = el('div', { className: 'lanes' });
  const span = Math.max(scale.high - scale.low, 1);
  const at = (value: number) => `${(100 * (value - scale.low)) / span}%`;
  const deepest = Math.max(...groups.map(({ contacts }) => contacts[0]!.depth ?? 0));
  const bar = (contact: Contact) => {
    const from = Math.min(contact.first_time, contact.frames[0]?.time ?? contact.first_time);
    const share = deepest > 0 ? (contact.depth ?? 0) / deepest : 0;
    return el('i', { className: 'bar', style: { left: at(from), width: `${(100 * (contact.last_time - from)) / span}%`, opacity: String(0.35 + 0.65 * share) } });
  };
  for (const { contacts, often } of groups.slice(0, kLaneLimit)) {
    const worst = contacts[0]!;
    const mark = worst.worst === null ? null : el('i', { className: 'worst', style: { left: at(worst.worst) } });
    const text = `${namesText(worst)}, ${framesText(contacts)}, ${[often, sizeText(worst, scale)].filter(Boolean).join(', ')}`;
    box.append(el('a', { href: `#contact-${worst.number}`, title: text, 'aria-label': text }, el('span', { className: 'label' }, worst.named ? namesText(worst) : `#${worst.number}`), el('span', { className: 'track' }, ...contacts.map(bar), mark)));
  }
  box.append(el('div', { className: 'axis' }, el('span', {}, `frame ${time(scale.low)}`), el('span', {}, time(scale.high))));
  return box;
}

/** Contacts without a picture, in a table. */
function rest(groups: Group[], scale: Scale): HTMLElement | null {
  if (groups.length === 0) return null;
  const row = ({ contacts, often }: Group) => {
    const worst = contacts[0]!;
    return el('tr', { id: `contact-${worst.number}` }, el('td', {}, worst.named ? namesText(worst) : `#${worst.number}`), el('td', {}, framesText(contacts)), el('td', {}, often), el('td', { className: 'number' }, sizeText(worst, scale)));
  };
  return el('div', { className: 'wide' }, el('table', {}, el('tbody', {}, ...groups.map(row))));
}

/** All contacts, the worst first; null if there are none. `count`: of all, also those that are not listed. `unlisted`: what they leave out, if anything. */
export function contactsSection(contacts: PicturedContact[], count: number, unlisted: string | undefined, scale: Scale, heading?: string): HTMLElement | null {
  if (contacts.length === 0) return null;
  const groups = groupsOf(contacts);
  const pictured = groups.filter((group) => (group.contacts[0] as PicturedContact).picture);
  const cards = pictured.length > 0 ? pictured : groups.slice(0, 1);
  const more = count - contacts.length;
  return el(
    'section',
    { className: 'contacts' },
    el('h2', {}, heading ? `${heading}: ${counted(count, 'contact')}` : count === 1 ? 'The contact' : `${grouped(count)} contacts, the worst first`),
    unlisted && el('p', { className: 'note' }, unlisted),
    scale.high > scale.low ? lanes(groups, scale) : null,
    el('div', { className: 'cards' }, ...cards.map((group) => card(group, scale))),
    rest(groups.filter((group) => !cards.includes(group)), scale),
    more > 0 ? el('p', { className: 'note' }, `${counted(more, 'more contact')} in the table of foldproof check --contacts-csv.`) : null,
  );
}
