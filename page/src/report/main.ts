// The report: the program embeds this script, its style and the data in one file that opens anywhere, offline.
import '../shared/base.css';
import './report.css';
import { contactsSection, type PicturedContact, type Scale } from './contacts';
import { repairSections, type RepairData } from './repair';
import { section, table } from './tables';
import { Charts } from '../shared/charts';
import { css, kReasons } from '../shared/colors';
import { unlistedText } from '../shared/contact';
import { el, notesOfReaders } from '../shared/dom';
import { counted, grouped, milliseconds, percent, short, toiText } from '../shared/format';
import { collisionsOf, spanOf, stepText, type Step } from '../shared/steps';
import { applyTheme, onTheme, startTheme, themeButton } from '../shared/theme';
import { sayAnswer, startText, type Answer, type Kind, type Start } from '../shared/verdict';
import { capital, isStatic, kBetweenNotTested, kStartNotTested, wordsOf } from '../shared/words';

interface Counts {
  vf: number;
  ee: number;
  tt?: number; // in a static check
}

/** Who made it, and how. */
interface Made {
  program: string;
  version: string;
  made: string;
  command: string;
  objects: { name: string }[];
}

interface Data extends Made {
  objects: { name: string; vertices: number; triangles: number; frames: number; model: string | null | { name: string }; notes?: string[]; unchecked?: string[] }[];
  settings: Record<string, unknown>;
  start: Start | null; // null if it was not tested
  totals: {
    steps: number;
    steps_expected: number;
    stopped: boolean;
    steps_with_collisions: number;
    collisions: Counts;
    earliest: { frame: number; substep: number; toi: number } | null;
    worst: { frame: number; substep: number; collisions: number | Counts } | null;
    tolerance: number;
    milliseconds: { total: number; update: number; traverse: number; narrow: number };
    work: Record<string, number>;
    missed?: number;
    listed?: Counts; // if it is fewer than all collisions
    contacts?: { count: number; unknown_frames: number };
  };
  steps: Step[];
  contacts: PicturedContact[];
  picture: string | null; // of the first frame, if there are no contacts
  verdict: Answer;
  notes: string[];
}

const kChartHeight = 190;

const total = (counts: number | Counts): number => (typeof counts === 'number' ? counts : counts.vf + counts.ee + (counts.tt ?? 0));

/** What the answer is based on. */
function kindOfProof(data: Data): string {
  if (data.settings['mode'] !== undefined) return 'The answer for the steps is statistical and can miss collisions.';
  if (isStatic(data.settings)) return `The answer is exact. ${kBetweenNotTested}`;
  if (isSingle(data)) return 'The answer is exact.';
  const steps = 'Nothing is sampled: between frames every vertex moves along a straight line, and a step with no pair listed is proven to have no contact.';
  if (data.start === null) return `${steps} A step finds only new contacts: ${kStartNotTested}, so parts may be inside each other without being listed.`;
  if (data.start.crossings > 0) return `${steps} Triangles that cross from the start can go on crossing without any contact.`;
  return steps;
}

/** What the verdict leaves out, in sentences. */
function summary(data: Data, substeps: number): string {
  const { totals } = data;
  const poses = isStatic(data.settings);
  const single = isSingle(data);
  const triangles = data.objects.reduce((sum, object) => sum + object.triangles, 0);
  const what = single ? 'A single frame' : counted(totals.steps, wordsOf(poses).step);
  const time = totals.milliseconds.total + (data.start?.ms.total ?? 0);
  const parts = [`${what} of ${counted(data.objects.length, 'object')} with ${counted(triangles, 'triangle')} ${single || totals.steps === 1 ? 'was' : 'were'} checked in ${milliseconds(time)}.`];
  if (data.verdict.numbers) parts.push(data.verdict.numbers);
  parts.push(...(poses ? posesText(data) : stepsText(data, single, substeps)), kindOfProof(data));
  return parts.join(' ');
}

/** What the steps of a motion found. */
function stepsText({ totals }: Data, single: boolean, substeps: number): string[] {
  const parts: string[] = [];
  const where = (step: { frame: number; substep: number }) => `frame ${step.frame}${substeps > 1 ? `, part ${step.substep + 1} of ${substeps}` : ''}`;
  const pairs = total(totals.collisions);
  if (pairs > 0) parts.push(`${counted(pairs, 'pair')} of features ${pairs === 1 ? 'collides' : 'collide'}: ${counted(totals.collisions.vf, 'vertex–face pair')} and ${grouped(totals.collisions.ee)} edge–edge.`);
  if (totals.worst && !single) parts.push(`The step with the most starts at ${where(totals.worst)}, with ${counted(total(totals.worst.collisions), 'pair')}.`);
  const undecided = totals.work['undecided'] ?? 0;
  if (undecided > 0) parts.push(`${counted(undecided, 'pair')} could not be decided within the iteration limit and ${undecided === 1 ? 'is' : 'are'} counted as collisions.`);
  return parts;
}

/** Which frames of a static check have crossings. */
function posesText({ totals: { earliest, steps, worst } }: Data): string[] {
  if (steps === 1 || !earliest || !worst) return [];
  return [`The first frame with crossings is ${earliest.frame}.`, `The worst is frame ${worst.frame}, with ${counted(total(worst.collisions), 'pair')}.`];
}

const isSingle = ({ steps }: Data): boolean => steps.length === 1 && steps[0]!.frame === steps[0]!.next_frame;

/** The two tests of a motion, which only together prove that nothing intersects; or that of all poses. */
function tests(data: Data): HTMLElement {
  const { settings, start, totals } = data;
  const single = isSingle(data);
  const poses = isStatic(settings);
  const found = total(totals.collisions);
  const first = data.steps[0]?.frame ?? start?.frame ?? 0;
  const last = data.steps.at(-1)?.next_frame ?? first;
  const answer = (text: string, kind: Kind) => el('span', { className: `answer ${kind}` }, text);
  const crossings = start === null ? answer('not tested (--steps-only)', 'run') : start.crossings === 0 ? answer('none', 'free') : answer(counted(start.crossings, 'pair'), 'hit');
  const { step } = wordsOf(poses);
  const pairs = found > 0 ? `${counted(found, 'pair')}${single ? '' : ` in ${grouped(totals.steps_with_collisions)} of ${counted(totals.steps, step)}`}` : 'none';
  const contacts = answer(pairs, found > 0 ? 'hit' : poses || start?.crossings === 0 ? 'free' : 'run');
  const second = single ? `Pairs in contact in frame ${first}` : `Contacts in the steps from frame ${first} to ${last}`;
  const startRow = [`Triangles that cross in frame ${first}`, crossings, start === null ? '–' : milliseconds(start.ms.total)];
  const stepsRow = [poses ? `Triangles that cross in ${single ? `frame ${first}` : `frames ${first} to ${last}`}` : second, contacts, milliseconds(totals.milliseconds.total)];
  return section('Results', table(['test', 'result', 'time'], poses ? [stepsRow] : [startRow, stepsRow], [false, false, true]));
}

function reasonsTable(data: Data): HTMLElement | null {
  const sums = data.steps.reduce<number[]>((all, step) => step.reasons.map((n, k) => n + (all[k] ?? 0)), []);
  const every = sums.reduce((a, b) => a + b, 0);
  if (every === 0) return null;
  const names = Object.values(kReasons);
  const rows = sums.flatMap((n, k) => {
    const reason = names[k];
    if (n === 0 || !reason) return [];
    const mark = el('span', { className: 'reason' }, el('span', { className: 'swatch', style: { background: css(reason.color) } }), reason.title);
    return [[mark, grouped(n), percent(n / every), reason.help]];
  });
  return section('What was proven, and why not the rest', el('p', {}, 'Pairs of leaves, patches of a dozen triangles or so, whose boxes come near each other; sums over everything that was checked.'), table(['', 'leaf pairs', 'share', ''], rows, [false, true, true, false]));
}

function worstSteps(data: Data, substeps: number): HTMLElement | null {
  const poses = isStatic(data.settings);
  const { step, collisions } = wordsOf(poses);
  const worst = data.steps.filter((step) => collisionsOf(step) > 0).sort((a, b) => collisionsOf(b) - collisionsOf(a)).slice(0, 10);
  if (worst.length === 0) return null;
  return section(
    worst.length < 10 ? `${capital(step)}s with ${collisions}` : `The ten worst ${step}s`,
    poses
      ? table(['frame', 'crossing pairs', 'time'], worst.map((pose) => [String(pose.frame), grouped(pose.crossings), milliseconds(pose.ms.total)]), [false, true, true])
      : table(
          ['step', 'vertex–face', 'edge–edge', 'first contact (share of the step)', 'time'],
          worst.map((one) => [stepText(one, substeps), grouped(one.vertex_face), grouped(one.edge_edge), toiText(one.toi), milliseconds(one.ms.total)]),
          [false, true, true, true, true],
        ),
  );
}

const plain = (value: unknown): string => {
  if (value === null || value === undefined) return '–';
  if (typeof value === 'boolean') return value ? 'yes' : 'no';
  if (typeof value === 'number') return short(value);
  if (typeof value === 'object') return Object.entries(value).map(([key, part]) => `${key} ${plain(part)}`).join(', ');
  return String(value);
};

const strideOf = (settings: Data['settings']): number => (settings['frames'] as { step: number }).step;

function makeCharts(data: Data, substeps: number): { charts: Charts; box: HTMLElement } {
  const span = (step: Step) => spanOf(step, substeps, strideOf(data.settings));
  const poses = isStatic(data.settings);
  const charts = new Charts({
    poses,
    spanOf: span,
    steps: data.steps,
    low: span(data.steps[0]!)[0],
    high: span(data.steps.at(-1)!)[1],
    height: kChartHeight,
    leaveOut: (values) => values.every((value) => value === 0),
  });
  return { charts, box: section(`${capital(wordsOf(poses).step)} by ${wordsOf(poses).step}`, charts.element) };
}

function build(data: Data): void {
  const substeps = Number(data.settings['substeps'] ?? 1) || 1;
  const { listed, collisions, contacts } = data.totals;
  const verdict = sayAnswer(data.verdict);
  const charts = data.steps.length > 0 && !isSingle(data) ? makeCharts(data, substeps) : null;
  const model = (value: Data['objects'][number]['model']) => (value === null ? 'none' : typeof value === 'string' ? value : value.name);
  const page = el(
    'main',
    { className: 'report' },
    el('header', {}, el('div', {}, el('p', { className: 'brand' }, 'Foldproof report'), el('h1', { className: verdict.kind }, verdict.text)), themeButton()),
    el('p', { className: 'lead' }, summary(data, substeps)),
    ...notesOfReaders(data.objects),
    ...data.notes.map((note) => el('p', { className: 'note' }, note)),
    contactsSection(data.contacts, contacts?.count ?? 0, listed && unlistedText(total(listed), total(collisions), isStatic(data.settings)), scaleOf(data)),
    tests(data),
    firstFrame(data),
    section(
      'Objects',
      table(['object', 'vertices', 'triangles', 'frames', 'model'], data.objects.map((o) => [o.name, grouped(o.vertices), grouped(o.triangles), grouped(o.frames), model(o.model)]), [false, true, true, true, false]),
    ),
    charts?.box,
    isSingle(data) ? null : worstSteps(data, substeps),
    reasonsTable(data),
    section('Settings', table(['setting', 'value'], Object.entries(data.settings).map(([key, value]) => [key, plain(value)]), [false, false]), isStatic(data.settings) ? null : el('p', { className: 'note' }, `Largest tolerance used: ${short(data.totals.tolerance)} mesh units.`)),
    footer(data),
  );
  document.body.replaceChildren(page);
  if (!charts) return;
  charts.charts.setSteps(data.steps);
  if (data.start && data.start.crossings > 0) charts.charts.setStart(data.start.frame, startText(data.start));
  onTheme(() => charts.charts.restyle());
  window.addEventListener('beforeprint', () => charts.charts.restyle());
}

function footer({ program, version, made, command }: Made): HTMLElement {
  return el('footer', {}, el('p', {}, `Made by ${program} ${version} on ${made} with`), el('pre', {}, command));
}

function scaleOf(data: Data): Scale {
  const { settings, steps, totals } = data;
  const [first, last] = [steps[0], steps.at(-1)];
  return { unit: String(settings['unit'] ?? ''), poses: isStatic(settings), single: isSingle(data), unknownFrames: totals.contacts?.unknown_frames ?? 0, low: first?.frame ?? 0, high: last?.next_frame ?? 0 };
}

/** What was checked, if there is no contact to show. */
function firstFrame({ picture, start, steps }: Data): HTMLElement | null {
  if (!picture) return null;
  const caption = `Frame ${steps[0]?.frame ?? start?.frame ?? 0}`;
  return el('figure', {}, el('img', { src: picture, alt: caption }), el('figcaption', {}, caption));
}

startTheme();
// Print in the light theme.
window.addEventListener('beforeprint', () => (document.documentElement.dataset['theme'] = 'light'));
window.addEventListener('afterprint', applyTheme);
const source = document.getElementById('data');
if (source?.textContent) {
  const data = JSON.parse(source.textContent) as Data | (Made & RepairData);
  document.title = `${data.objects.map(({ name }) => name).join(', ')} – ${data.program} report`;
  if ('repair' in data) document.body.replaceChildren(el('main', { className: 'report' }, ...repairSections(data), footer(data)));
  else build(data);
} else {
  document.body.append(el('p', {}, 'This report has no data in it: make it again with foldproof report.'));
}
