// The report: the program puts this script, its style and the data into one file that opens anywhere, offline.
import '../shared/base.css';
import './report.css';
import { Charts } from '../shared/charts';
import { css, kReasons } from '../shared/colours';
import { append, el } from '../shared/dom';
import { counted, grouped, milliseconds, percent, short, toiText } from '../shared/format';
import { beginOf, collisionsOf, placeText, type Step } from '../shared/steps';
import { applyTheme, onTheme, startTheme, themeButton } from '../shared/theme';

interface Counts {
  vf: number;
  ee: number;
}

interface Data {
  program: string;
  version: string;
  made: string;
  command: string;
  objects: { name: string; vertices: number; triangles: number; frames: number; model: string | null | { name: string } }[];
  settings: Record<string, unknown>;
  totals: {
    steps: number;
    steps_with_collisions: number;
    collisions: Counts;
    earliest: { frame: number; substep: number; toi: number } | null;
    worst: { frame: number; substep: number; collisions: number | Counts } | null;
    tolerance: number;
    milliseconds: { total: number; update: number; traverse: number; narrow: number };
    work: Record<string, number>;
    missed?: number;
  };
  steps: Step[];
  pictures: { step: number; caption: string; png: string }[];
  notes: string[];
}

const kChartHeight = 190;

const numberCell = (text: string): HTMLElement => el('td', { className: 'number' }, text);

function table(heads: string[], rows: (string | HTMLElement)[][], numbers: boolean[]): HTMLElement {
  const cell = (value: string | HTMLElement, k: number) => (numbers[k] && typeof value === 'string' ? numberCell(value) : el('td', {}, value));
  return el(
    'div',
    { className: 'wide' },
    el(
      'table',
      {},
      append_(el('thead', {}), [append_(el('tr', {}), heads.map((head, k) => el('th', { className: numbers[k] ? 'number' : '' }, head)))]),
      append_(el('tbody', {}), rows.map((row) => append_(el('tr', {}), row.map(cell)))),
    ),
  );
}

function append_<T extends HTMLElement>(parent: T, children: HTMLElement[]): T {
  append(parent, ...children);
  return parent;
}

const total = (counts: number | Counts): number => (typeof counts === 'number' ? counts : counts.vf + counts.ee);

/** What was found, in sentences. */
function summary(data: Data, substeps: number): { verdict: string; text: string; free: boolean } {
  const { totals } = data;
  const statistical = data.settings['mode'] === 'paper';
  const pairs = totals.collisions.vf + totals.collisions.ee;
  const triangles = data.objects.reduce((sum, object) => sum + object.triangles, 0);
  const checked = `${counted(totals.steps, 'step')} of ${counted(data.objects.length, 'object')} with ${counted(triangles, 'triangle')} ${totals.steps === 1 ? 'was' : 'were'} checked in ${milliseconds(totals.milliseconds.total)}`;
  const kind = statistical
    ? 'The answer is statistical and can miss collisions.'
    : 'Nothing is sampled: between frames every vertex moves along a straight line, and whatever is not listed is proven free of contact.';
  if (pairs === 0) {
    return { verdict: statistical ? 'No collision was found' : 'The motion is free of collisions', text: `${checked}. ${kind}`, free: true };
  }
  const where = (place: { frame: number; substep: number }) => `frame ${place.frame}${substeps > 1 ? `, part ${place.substep + 1} of ${substeps}` : ''}`;
  const parts = [`${checked}.`, `${counted(pairs, 'pair')} of features ${pairs === 1 ? 'collides' : 'collide'}: ${counted(totals.collisions.vf, 'vertex–face pair')} and ${grouped(totals.collisions.ee)} edge–edge.`];
  if (totals.earliest) parts.push(`The first contact comes ${toiText(totals.earliest.toi)} of the way from ${where(totals.earliest)}.`);
  if (totals.worst) parts.push(`The worst step starts at ${where(totals.worst)}, with ${counted(total(totals.worst.collisions), 'pair')}.`);
  const undecided = totals.work['undecided'] ?? 0;
  if (undecided > 0) parts.push(`${counted(undecided, 'pair')} could not be decided within the iteration limit and ${undecided === 1 ? 'is' : 'are'} counted as collisions.`);
  return { verdict: `The motion collides in ${grouped(totals.steps_with_collisions)} of ${counted(totals.steps, 'step')}`, text: [...parts, kind].join(' '), free: false };
}

function reasonsTable(data: Data): HTMLElement | null {
  const sums = data.steps.reduce<number[]>((all, step) => step.reasons.map((n, k) => n + (all[k] ?? 0)), []);
  const every = sums.reduce((a, b) => a + b, 0);
  if (every === 0) return null;
  const names = Object.values(kReasons);
  const rows = sums.flatMap((n, k) => {
    const reason = names[k];
    if (n === 0 || !reason) return [];
    const mark = el('span', { className: 'reason' }, el('span', { className: 'swatch', style: { background: css(reason.colour) } }), reason.title);
    return [[mark, grouped(n), percent(n / every), reason.help]];
  });
  return section('What was proven, and why not the rest', el('p', {}, 'Pairs of leaves, patches of a dozen triangles or so, whose boxes come near each other; sums over the steps.'), table(['', 'leaf pairs', 'share', ''], rows, [false, true, true, false]));
}

function section(title: string, ...content: (HTMLElement | null)[]): HTMLElement {
  return el('section', {}, el('h2', {}, title), ...content);
}

function worstSteps(data: Data, substeps: number): HTMLElement | null {
  const worst = data.steps.filter((step) => collisionsOf(step) > 0).sort((a, b) => collisionsOf(b) - collisionsOf(a)).slice(0, 10);
  if (worst.length === 0) return null;
  return section(
    worst.length < 10 ? 'Steps with collisions' : 'The ten worst steps',
    table(
      ['step', 'vertex–face', 'edge–edge', 'first contact (share of the step)', 'time'],
      worst.map((step) => [placeText(step, substeps), grouped(step.vertex_face), grouped(step.edge_edge), toiText(step.toi), milliseconds(step.ms.total)]),
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

function makeCharts(data: Data, substeps: number): { charts: Charts; box: HTMLElement } {
  const first = data.steps[0]!;
  const last = data.steps[data.steps.length - 1]!;
  const charts = new Charts({
    substeps,
    low: beginOf(first, substeps),
    high: beginOf(last, substeps) + (last.next_frame - last.frame) / substeps,
    height: kChartHeight,
  });
  return { charts, box: section('Step by step', charts.element) };
}

function build(data: Data): void {
  const substeps = Number(data.settings['substeps'] ?? 1) || 1;
  const { verdict, text, free } = summary(data, substeps);
  document.title = `${data.objects.map(({ name }) => name).join(', ')} – ${data.program} report`;
  const charts = data.steps.length > 0 ? makeCharts(data, substeps) : null;
  const model = (value: Data['objects'][number]['model']) => (value === null ? 'none' : typeof value === 'string' ? value : value.name);
  const page = el(
    'main',
    { className: 'report' },
    el('header', {}, el('div', {}, el('p', { className: 'brand' }, 'Foldproof report'), el('h1', { className: free ? 'free' : 'hit' }, verdict)), themeButton()),
    el('p', { className: 'lead' }, text),
    ...data.notes.map((note) => el('p', { className: 'note' }, note)),
    pictures(data),
    section(
      'Objects',
      table(['object', 'vertices', 'triangles', 'frames', 'model'], data.objects.map((o) => [o.name, grouped(o.vertices), grouped(o.triangles), grouped(o.frames), model(o.model)]), [false, true, true, true, false]),
    ),
    charts?.box,
    worstSteps(data, substeps),
    reasonsTable(data),
    section('Settings', table(['setting', 'value'], Object.entries(data.settings).map(([key, value]) => [key, plain(value)]), [false, false]), el('p', { className: 'note' }, `Largest tolerance used: ${short(data.totals.tolerance)} mesh units.`)),
    el('footer', {}, el('p', {}, `Made by ${data.program} ${data.version} on ${data.made} with`), el('pre', {}, data.command)),
  );
  document.body.replaceChildren(page);
  if (!charts) return;
  charts.charts.setSteps(data.steps);
  onTheme(() => charts.charts.restyle());
  // Paper is white.
  window.addEventListener('beforeprint', () => {
    document.documentElement.dataset['theme'] = 'light';
    charts.charts.restyle();
  });
  window.addEventListener('afterprint', applyTheme);
}

function pictures(data: Data): HTMLElement | null {
  if (data.pictures.length === 0) return null;
  const box = el('div', { className: 'pictures' });
  for (const picture of data.pictures) box.append(el('figure', {}, el('img', { src: picture.png, alt: picture.caption }), el('figcaption', {}, picture.caption)));
  return section('The worst steps', box);
}

startTheme();
const source = document.getElementById('data');
if (source?.textContent) build(JSON.parse(source.textContent) as Data);
else document.body.append(el('p', {}, 'This report has no data in it: make it again with foldproof report.'));
