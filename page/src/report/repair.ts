// The report of a repair: the worst contacts before and after, how far each frame was moved, and what remains.
import { contactsSection, framesText, sizeText, title, type PicturedContact, type Scale } from './contacts';
import { section, table } from './tables';
import { groupsOf } from '../shared/contact';
import { el, notesOfReaders } from '../shared/dom';
import { counted, grouped, lengthText, short } from '../shared/format';
import { themeButton } from '../shared/theme';
import { sayAnswer, type Answer } from '../shared/verdict';

interface Frame {
  time: number;
  correction: number; // mesh units
  late: boolean;
  limit: 'none' | 'no_free_start' | 'given_up';
}

type Lists = 'before' | 'remaining' | 'left' | 'among_fixed';

/** What `repair --json` writes, and what was asked for. */
export interface Repair extends Record<Lists, PicturedContact[]> {
  verdict: Answer;
  unchanged: boolean;
  written: boolean;
  open_loop: boolean;
  thickness: number;
  falloff: number;
  clearance: number;
  unit?: string;
  frames: Frame[];
  counts: Record<Lists, number>; // those that are listed may be fewer
  fixed: string[];
  only: string[];
  ignore: [string, string][];
  between: [string, string][]; // whose contacts alone were to be repaired
}

export interface Pictures {
  contact: number;
  remains: boolean; // something of it still touches
  before: string;
  after: string | null; // null: its frames were not written
}

export interface RepairData {
  repair: Repair;
  pictures: Pictures[];
  objects: { name: string; vertices: number; triangles: number; frames: number; notes?: string[] }[];
}

const kBars = 240;
const kMostMoved = 10;
const kLimits = { none: '', no_free_start: 'something touches: it was in contact where the repair began', given_up: 'something touches: no way was found, and the frame is as it was' };

const touches = ({ limit }: Frame): boolean => limit !== 'none';
const isOfInput = ({ time }: Frame): boolean => Number.isInteger(time);
const notesOf = (frame: Frame): string => [kLimits[frame.limit], frame.late && 'behind the motion'].filter(Boolean).join('; ');
const largest = (frames: Frame[]): Frame => frames.reduce((a, b) => (b.correction > a.correction ? b : a));

function lead({ repair, objects }: RepairData, unit: string): string {
  const { counts, frames } = repair;
  const parts = [`${counted(frames.filter(isOfInput).length, 'frame')} of ${counted(objects.length, 'object')} (${counted(objects.reduce((sum, { triangles }) => sum + triangles, 0), 'triangle')}), with ${counts.before === 0 ? 'no contacts' : counted(counts.before, 'contact')}${counts.left > 0 ? ' to repair' : ''}.`];
  if (!repair.written || repair.unchanged) return parts[0]!;
  const worst = largest(frames);
  const added = frames.filter((frame) => !isOfInput(frame)).length;
  const still = frames.filter(({ correction }) => correction === 0).length;
  parts.push(`${still > 0 ? `${grouped(frames.length - still)} of them were` : frames.length > 1 ? 'All were' : 'It was'} moved, by at most ${lengthText(worst.correction, unit)}${frames.length > 1 ? ` in frame ${short(worst.time)}` : ''}.`);
  if (added > 0) parts.push(`${counted(added, 'frame')} added between others.`);
  parts.push(`Surfaces are kept ${lengthText(repair.clearance + repair.thickness, unit)} apart.`);
  if (repair.open_loop) parts.push('The motion ends as it begins; what was written does not.');
  return parts.join(' ');
}

function comparison({ repair }: RepairData, { contact: number, remains, before, after }: Pictures, scale: Scale): HTMLElement | null {
  const group = groupsOf(repair.before).find(({ contacts }) => contacts[0]!.number === number);
  if (!group) return null;
  const contact = group.contacts[0]!;
  const shown = short(contact.worst ?? contact.first_time);
  const picture = (source: string, what: string) => el('figure', {}, el('img', { src: source, alt: `Frame ${shown}, ${what}` }), el('figcaption', {}, `Frame ${shown}, ${what}`));
  const moved = () => largest(repair.frames.filter(({ time }) => Math.floor(contact.first_time) <= time && time <= Math.ceil(contact.last_time))).correction;
  const answer = remains ? 'remains' : after === null ? 'not written' : 'repaired';
  const facts: [string, string][] = [
    ['before', `${[group.often, sizeText(contact, scale)].filter(Boolean).join(', ')}; ${framesText(group.contacts)}`],
    ['after', remains ? 'something touches here' : after === null ? 'not written' : `nothing touches; there vertices were moved by at most ${lengthText(moved(), scale.unit)}`],
  ];
  const list = el('dl', {}, ...facts.flatMap(([key, value]) => [el('dt', {}, key), el('dd', {}, value)]));
  return el('article', { className: 'contact comparison' }, el('header', {}, title(contact), el('b', { className: `answer ${answer === 'repaired' ? 'free' : 'hit'}` }, answer)), el('div', { className: 'pair' }, picture(before, 'before'), after && picture(after, 'after')), list);
}

/** The largest correction of each frame, or of several where there are many. */
function corrections(frames: Frame[], unit: string): HTMLElement {
  const each = Math.ceil(frames.length / kBars);
  const highest = largest(frames).correction;
  const bars = Array.from({ length: Math.ceil(frames.length / each) }, (_, k) => {
    const part = frames.slice(k * each, (k + 1) * each);
    const { correction } = largest(part);
    const state = part.some(touches) ? 'hit' : part.some(({ late }) => late) ? 'stopped' : '';
    const [from, to] = [short(part[0]!.time), short(part.at(-1)!.time)];
    return el('i', { className: state, title: `${from === to ? `frame ${from}` : `frames ${from} to ${to}`}: ${lengthText(correction, unit)}`, style: { height: highest > 0 ? `${(100 * correction) / highest}%` : '0' } });
  });
  const marks = [frames.some(({ late }) => late) && 'orange: behind the motion', frames.some(touches) && 'red: something touches'].filter(Boolean).join('; ');
  return section(
    'How far each frame was moved',
    el('p', {}, `The largest distance that a vertex was moved, up to ${lengthText(highest, unit)}${marks && ` (${marks})`}.`),
    el('div', { className: 'bars', role: 'img', 'aria-label': `Largest corrections of frames ${short(frames[0]!.time)} to ${short(frames.at(-1)!.time)}` }, ...bars),
    el('div', { className: 'axis' }, el('span', {}, `frame ${short(frames[0]!.time)}`), el('span', {}, short(frames.at(-1)!.time))),
  );
}

function mostMoved(frames: Frame[], unit: string): HTMLElement {
  const most = frames.filter(({ correction }) => correction > 0).sort((a, b) => b.correction - a.correction).slice(0, kMostMoved);
  return section(most.length < kMostMoved ? 'Frames that were moved' : 'The ten frames that were moved most', table(['frame', 'moved by', ''], most.map((frame) => [short(frame.time), lengthText(frame.correction, unit), notesOf(frame)]), [false, true, false]));
}

function settings({ between, falloff, fixed, ignore, only, thickness, unit = '' }: Repair): HTMLElement {
  const length = (value: number) => (value > 0 ? lengthText(value, unit) : '0');
  const pairs = (names: [string, string][]) => names.map((pair) => pair.join(' – ')).join(', ');
  const rows = [
    ['thickness', length(thickness)],
    ['falloff', falloff > 0 ? length(falloff) : ''],
    ['fixed', fixed.join(', ')],
    ['only', only.join(', ')],
    ['ignore', pairs(ignore)],
    ['contact', pairs(between)],
  ].filter(([, value]) => value);
  return section('Settings', table(['setting', 'value'], rows as string[][], [false, false]));
}

/** The sections of the page but for its footer. */
export function repairSections(data: RepairData): (HTMLElement | null)[] {
  const { repair, objects } = data;
  const unit = repair.unit ?? '';
  const verdict = sayAnswer(repair.verdict);
  const moved = repair.written && !repair.unchanged;
  const [low, high] = [repair.frames[0]!.time, repair.frames.at(-1)!.time];
  const scale: Scale = { unit, poses: false, single: low === high, unknownFrames: 0, low, high };
  const cards = data.pictures.map((pictures) => comparison(data, pictures, scale));
  const listed = (list: Lists, heading: string) => (contactsSection(repair[list], repair.counts[list], undefined, scale, heading));
  return [
    el('header', {}, el('div', {}, el('p', { className: 'brand' }, 'Foldproof repair'), el('h1', { className: verdict.kind }, verdict.text)), themeButton()),
    el('p', { className: 'lead' }, lead(data, unit)),
    ...notesOfReaders(objects),
    cards.length > 0 ? section(moved ? 'Before and after, the worst first' : 'The worst contacts', el('div', { className: 'cards' }, ...cards)) : null,
    listed('remaining', 'What remains'),
    moved && repair.frames.length > 1 ? corrections(repair.frames, unit) : null,
    moved && repair.frames.length > 1 ? mostMoved(repair.frames, unit) : null,
    listed('left', 'What was left'),
    listed('among_fixed', 'What may not move, with itself'),
    section('Objects', table(['object', 'vertices', 'triangles', 'frames'], objects.map((o) => [o.name, grouped(o.vertices), grouped(o.triangles), grouped(o.frames)]), [false, true, true, true])),
    settings(repair),
  ];
}
