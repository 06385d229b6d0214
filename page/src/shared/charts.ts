// Charts of the check's results and work by step; the page links them to its timeline.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { el } from './dom';
import { brief, grouped, milliseconds } from './format';
import type { Step } from './steps';
import { capital, wordsOf } from './words';

interface Series {
  label: string;
  color: string; // a CSS variable
  value: (step: Step) => number;
}

interface Chart {
  id: string;
  title: string;
  unit: string;
  stacked: boolean;
  spread?: boolean; // a nearly logarithmic scale (asinh) that includes zero
  series: Series[];
}

const kPairs: Series[] = [
  { label: 'edge–edge', color: '--c-ee', value: (s) => s.edge_edge },
  { label: 'vertex–face', color: '--c-vf', value: (s) => s.vertex_face },
];
const kCrossings: Series[] = [{ label: 'pairs of triangles', color: '--c-vf', value: (s) => s.crossings }];

// The parts of a stack are listed from the bottom up.
const chartsOf = (poses: boolean, { step, collisions } = wordsOf(poses)): Chart[] => [
  { id: 'inside', title: 'Inside or crossing', unit: 'triangles', stacked: false, series: [{ label: 'triangles', color: '--c-vf', value: (s) => Math.max(s.inside[0] ?? 0, s.inside[1] ?? 0) }] },
  { id: 'collisions', title: capital(collisions), unit: `pairs per ${step}`, stacked: true, series: poses ? kCrossings : kPairs },
  {
    id: 'time',
    title: `Time per ${step}, by stage`,
    unit: 'ms',
    stacked: true,
    series: [
      { label: 'update', color: '--c-update', value: (s) => s.ms.update },
      { label: 'traverse', color: '--c-traverse', value: (s) => s.ms.traverse },
      { label: 'narrow', color: '--c-narrow', value: (s) => s.ms.narrow },
      {
        label: 'other',
        color: '--c-other',
        value: (s) => Math.max(0, s.ms.total - s.ms.update - s.ms.traverse - s.ms.narrow),
      },
    ],
  },
  {
    id: 'tests',
    title: 'Tests and culls',
    unit: `count per ${step}`,
    stacked: false,
    spread: true,
    series: [
      { label: 'node pairs', color: '--c-nodes', value: (s) => s.node_tests },
      { label: 'proofs tried', color: '--c-tests', value: (s) => s.certificate_tests },
      { label: 'proofs found (culls)', color: '--c-passes', value: (s) => s.certificate_passes },
      { label: 'leaf pairs tested', color: '--c-leaves', value: (s) => s.leaf_pairs },
    ],
  },
  {
    id: 'candidates',
    title: 'Candidates for the narrow phase',
    unit: `pairs per ${step}`,
    stacked: false,
    series: [{ label: 'candidates', color: '--c-candidates', value: (s) => s.candidates }],
  },
];

const variable = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

const decades = (_: uPlot, __: number, ___: number, high: number): number[] => [0, ...Array.from({ length: 12 }, (____, k) => 10 ** (k + 1)).filter((tick) => tick <= high)];

/** The interval of the axis in which a step is drawn. */
type SpanOf = (step: Step) => [number, number];

/** Columns for uPlot: a value applies from the start to the end of its step. */
function columns(chart: Chart, steps: Step[], spanOf: SpanOf): uPlot.AlignedData {
  const last = steps.at(-1);
  const closed = last ? [...steps, last] : [];
  const x = steps.map((step) => spanOf(step)[0]);
  if (last) x.push(spanOf(last)[1]);
  const rows = chart.series.map((series) => closed.map((step) => series.value(step)));
  if (chart.stacked) {
    for (let s = 1; s < rows.length; ++s) rows[s] = rows[s]!.map((value, k) => value + rows[s - 1]![k]!);
    rows.reverse(); // the highest is drawn first
  }
  return [x, ...rows];
}

export interface ChartOptions {
  poses: boolean;
  spanOf: SpanOf;
  steps?: Step[]; // to begin with
  low: number;
  high: number; // the frames at both ends of the axis
  height: number;
  seek?: (step: number) => void; // called on a click, with the step's number
  leaveOut?: (values: number[]) => boolean; // charts of these values
}

export class Charts {
  readonly element = el('div', { className: 'charts' });
  private readonly plots: { chart: Chart; plot: uPlot; box: HTMLElement; now: HTMLElement; start: HTMLElement }[] = [];
  private readonly sync = uPlot.sync('steps');
  private readonly resize = new ResizeObserver(() => this.fit());
  private steps: Step[] = [];
  private position = 0;
  private current = 0;
  private hovering = false;
  private start: { frame: number; text: string } | null = null;

  constructor(private readonly options: ChartOptions) {
    this.resize.observe(this.element);
    this.steps = options.steps ?? [];
    this.build();
  }

  /** All steps so far. */
  setSteps(steps: Step[]): void {
    this.steps = steps;
    for (const { chart, plot } of this.plots) {
      plot.setData(columns(chart, steps, this.options.spanOf));
    }
    this.showValues();
    this.moveNow();
  }

  /** Marks the first frame, in which triangles cross, and adds an explanation under the chart of collisions. */
  setStart(frame: number, text: string): void {
    this.start = { frame, text };
    for (const { chart, box, start } of this.plots) {
      start.hidden = false;
      start.title = text;
      if (chart.id === 'collisions' && !box.querySelector('.starts')) box.append(el('p', { className: 'starts' }, el('span', { className: 'swatch crossing' }), text));
    }
    this.moveNow();
  }

  /** Sets the timeline's position: in frames, and the step's number. */
  setNow(position: number, step: number): void {
    this.position = position;
    const moved = step !== this.current;
    this.current = step;
    if (moved) this.showValues();
    this.moveNow();
  }

  /** Rebuilds the charts in the colors of the current theme. */
  restyle(): void {
    for (const { plot } of this.plots) plot.destroy();
    this.plots.length = 0;
    this.element.replaceChildren();
    this.build();
    this.setSteps(this.steps);
    if (this.start) this.setStart(this.start.frame, this.start.text);
  }

  private shown(): Chart[] {
    const { leaveOut, poses } = this.options;
    return chartsOf(poses).filter((chart) => !leaveOut?.(chart.series.flatMap((series) => this.steps.map((step) => series.value(step)))));
  }

  private build(): void {
    for (const chart of this.shown()) {
      const box = el('section', { className: 'chart', 'data-chart': chart.id }, el('h3', {}, `${chart.title} `, el('small', {}, chart.spread ? `${chart.unit}, logarithmic` : chart.unit)));
      this.element.append(box);
      const plot = new uPlot(this.describe(chart), columns(chart, [], this.options.spanOf), box);
      const now = el('div', { className: 'now' });
      const start = el('div', { className: 'start-mark', hidden: true });
      plot.over.append(start);
      if (this.options.seek) plot.over.append(now);
      plot.over.addEventListener('mouseenter', () => (this.hovering = true));
      plot.over.addEventListener('mouseleave', () => {
        this.hovering = false;
        this.showValues();
      });
      plot.over.addEventListener('click', () => {
        const step = this.steps[this.indexAt(plot.posToVal(plot.cursor.left ?? 0, 'x'))];
        if (step) this.options.seek?.(step.number);
      });
      this.plots.push({ chart, plot, box, now, start });
    }
  }

  /** The step at a place of the axis. */
  private indexAt(x: number): number {
    const after = this.steps.findIndex((step) => x < this.options.spanOf(step)[1]);
    return after < 0 ? this.steps.length - 1 : after;
  }

  private describe(chart: Chart): uPlot.Options {
    const axis = { stroke: variable('--soft'), grid: { stroke: variable('--line'), width: 1 }, ticks: { stroke: variable('--line'), width: 1 }, font: '11px system-ui, sans-serif' };
    const series = chart.stacked ? [...chart.series].reverse() : chart.series;
    return {
      width: this.width(),
      height: this.options.height,
      padding: [8, 10, 0, 0],
      cursor: { sync: { key: this.sync.key }, points: { show: false }, y: false, drag: { x: false, y: false }, dataIdx: (_, __, ___, x) => this.indexAt(x) },
      scales: {
        x: { time: false, range: () => [this.options.low, Math.max(this.options.high, this.options.low + 1)] },
        y: { range: (_, __, high) => [0, high > 0 ? high * (chart.spread ? 1.6 : 1.08) : 1], ...(chart.spread ? { distr: 4 as const, asinh: 10 } : {}) },
      },
      axes: [
        { ...axis, size: 36, label: 'frame', labelSize: 14, labelFont: '11px system-ui, sans-serif', labelGap: 0, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000] },
        { ...axis, size: 58, label: chart.unit, labelSize: 14, labelFont: '11px system-ui, sans-serif', labelGap: 0, values: (_, ticks) => ticks.map((tick: number | null) => (tick === null ? '' : brief(tick))), ...(chart.spread ? { splits: decades, filter: (_: uPlot, ticks: number[]) => ticks } : {}) },
      ],
      series: [
        { label: 'frame', value: (_, x, __, index) => (x === null || x === undefined ? '–' : String(this.options.poses ? this.steps[index!]?.frame : Number(x.toFixed(3)))) },
        ...series.map((one) => this.line(chart, one)),
      ],
      legend: { live: true },
    };
  }

  private line(chart: Chart, series: Series): uPlot.Series {
    const color = variable(series.color);
    return {
      label: series.label,
      stroke: color,
      width: chart.stacked ? 1 : 1.75,
      ...(chart.stacked ? { fill: color } : {}),
      paths: uPlot.paths.stepped!({ align: 1 }),
      points: { show: false },
      // The legend shows a part's own value, not the height of the stack.
      value: (_, __, ___, index) => {
        const step = index === null || index === undefined ? undefined : this.steps[Math.min(index, this.steps.length - 1)];
        if (!step) return '–';
        const value = series.value(step);
        return chart.unit === 'ms' ? milliseconds(value) : grouped(value);
      },
    };
  }

  private width(): number {
    return Math.max(200, Math.floor(this.element.clientWidth) || 340);
  }

  private fit(): void {
    if (this.element.clientWidth === 0) return;
    for (const { plot } of this.plots) plot.setSize({ width: this.width(), height: this.options.height });
    this.moveNow();
  }

  private showValues(): void {
    if (this.hovering || !this.options.seek) return;
    const index = this.steps[this.current] ? this.current : null;
    for (const { plot } of this.plots) if (index !== null) plot.setLegend({ idx: index });
  }

  private moveNow(): void {
    for (const { plot, now, start } of this.plots) {
      now.style.transform = `translateX(${plot.valToPos(this.position, 'x')}px)`;
      if (this.start) start.style.transform = `translateX(${plot.valToPos(this.start.frame, 'x')}px)`;
    }
  }
}
