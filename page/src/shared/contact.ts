// Contacts, as the program writes them.
import { grouped, lengthText } from './format';
import { wordsOf } from './words';

export interface ContactFrame {
  time: number;
  crossings: number;
  triangles: number;
  curve_length: number;
  closed: boolean;
  touching: boolean; // nothing is inside
  depth: number | null;
  at_least: boolean; // it is a lower bound: both surfaces are open
}

/** What goes through what (docs/contacts.md). Times are frames of the motion. */
export interface Contact {
  number: number;
  joined: number[];
  group: number; // of contacts of the same two parts, by their worst ones
  often: string; // how often that is found: "4 times", "in 3 places"; empty for one
  named: boolean; // its sides are parts or two objects
  sides: { object: number; name: string; triangles?: number[]; inside?: number[] }[];
  folded: boolean;
  pierces?: boolean; // a line or a point goes through faces
  from_start: boolean;
  healed: boolean;
  first_time: number;
  last_time: number;
  pairs: number;
  depth: number | null;
  touching: boolean;
  worst: number | null; // the time of the worst frame
  point: [number, number, number];
  box: [number[], number[]];
  normal: number[];
  frames: ContactFrame[];
  curves?: number[][][];
  view?: [number, number, number]; // from where its sides and its curve are seen
}

/** Contacts of the same two parts: one thing that happens several times. */
export interface Group {
  contacts: Contact[]; // those that are listed, the worst first
  often: string; // of all of them
}

export function groupsOf(contacts: Contact[]): Group[] {
  const groups: Group[] = [];
  for (const contact of contacts) (groups[contact.group] ??= { contacts: [], often: contact.often }).contacts.push(contact);
  return groups.filter(Boolean);
}

/** "6.6 cm deep", "at least 2 cm", or how long the curve is where there is no depth */
export function depthText(frame: ContactFrame, unit: string): string {
  if (frame.touching) return 'touches';
  if (frame.depth === null) return `along ${lengthText(frame.curve_length, unit)}`;
  return `${frame.at_least ? 'at least ' : ''}${lengthText(frame.depth, unit)} deep`;
}

export function worstOf(contact: Contact): ContactFrame | undefined {
  return contact.frames.find(({ time }) => time === contact.worst);
}

/** The names of the two sides as one. */
export function namesText({ sides }: Contact): string {
  const [a, b] = [sides[0]!, sides[1]!];
  if (a.name !== b.name) return `${a.name} – ${b.name}`;
  return a.object === b.object ? `${a.name} with itself` : `${a.name} with another`;
}

/** Where a contact is, to a tenth of its size. */
export function placeText({ point, box: [low, high] }: Contact): string {
  const places = Math.ceil(Math.log10(Math.max(...point.map(Math.abs)) / Math.hypot(...high.map((value, axis) => value - low[axis]!))));
  const digits = Number.isFinite(places) ? Math.min(Math.max(places + 2, 3), 17) : 3;
  return `(${point.map((value) => String(Number(value.toPrecision(digits)))).join(', ')})`;
}

/** What a contact does that crosses in no frame, as far as is known. */
export const touchText = (unknownFrames: number, single: boolean): string => (unknownFrames > 0 ? 'touches; not known whether it crosses' : single ? 'touches' : 'touches between frames');

/** What contacts leave out where not all pairs are listed. */
export const unlistedText = (listed: number, pairs: number, poses: boolean): string => `Contacts join only the ${grouped(listed)} of ${grouped(pairs)} ${wordsOf(poses).colliding} pairs that are listed (--limit).`;
