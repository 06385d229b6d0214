// The overall result of a check, in the same words in the page and in the report.
import { counted, grouped, ordinal } from './format';
import { kStartNotTested, wordsOf } from './words';

/** The answer for the first frame. */
export interface Start {
  frame: number;
  crossings: number; // pairs of triangles
  listed: number; // of them, listed and marked
  ms: { total: number };
}

export interface Found {
  state: 'running' | 'done' | 'stopped' | 'failed' | 'gone';
  done: number;
  total: number; // expected steps
  pairs: number;
  colliding: number; // steps
  start: Start | null; // null if not tested, or not yet
  stepsOnly: boolean;
  statistical: boolean;
  single: boolean; // one frame, whose only step has no motion
  poses: boolean; // a static check, whose steps are poses
  assumed: string; // what files were taken for, ' between 3 frames of one mesh'; it follows what was checked
  untested: string; // what was left out, for the end of the verdict
}

export type Kind = 'run' | 'free' | 'hit' | 'stopped';

export interface Verdict {
  text: string;
  kind: Kind;
}

export const startText = ({ frame, crossings }: Start, single = false): string =>
  crossings === 0 ? `Nothing crosses in frame ${frame}` : `Frame ${frame} ${single ? 'has' : 'starts with'} ${counted(crossings, 'crossing pair')} of triangles`;

const pairsText = ({ pairs, poses }: Found): string => counted(pairs, `${wordsOf(poses).colliding} pair`) + (poses ? ' of triangles' : '');

const stepsText = ({ poses, total, assumed }: Found): string => counted(total, wordsOf(poses).step) + assumed;

export const stoppedText = (found: Found): string => `Stopped at ${grouped(found.done)} of ${stepsText(found)}`;

function stopped(found: Found): Verdict {
  const crosses = (found.start?.crossings ?? 0) > 0;
  const parts = [stoppedText(found)];
  if (crosses) parts.push(startText(found.start!, found.single).replace('Frame', 'frame'));
  if (found.pairs > 0) parts.push(`${pairsText(found)} until then`);
  if (parts.length === 1) parts.push('the rest is unknown');
  return { text: parts.join('; '), kind: crosses || found.pairs > 0 ? 'hit' : 'stopped' };
}

function running(found: Found): Verdict {
  const crosses = (found.start?.crossings ?? 0) > 0;
  const checking = found.single ? 'Checking' : `Checking: ${grouped(found.done)} of ${stepsText(found)}, ${counted(found.pairs, 'pair')} so far`;
  return { text: crosses ? `${startText(found.start!, found.single)}. ${checking}` : checking, kind: crosses || found.pairs > 0 ? 'hit' : 'run' };
}

function single(start: Start, pairs: number): Verdict {
  const crosses = start.crossings > 0;
  if (pairs > 0) return { text: `${startText(start, true)}; ${counted(pairs, 'pair')} in contact`, kind: 'hit' };
  return crosses ? { text: startText(start, true), kind: 'hit' } : { text: `Proven free: nothing crosses in frame ${start.frame}`, kind: 'free' };
}

/** What was ignored by name. */
function ignoredText({ ignore }: Record<string, unknown>): string {
  const pairs = Array.isArray(ignore) ? (ignore as [string, string][]) : [];
  const named = pairs.map(([a, b]) => `of ${a === b ? `${a} with itself` : `${a} and ${b}`}`);
  return named.length > 0 ? `; pairs ${named.join(', ')} were ignored` : '';
}

/** What was left out: ignored pairs, frames, pairs within meshes or between them, and what readers could not have checked, such as vertices in no face. */
export function untestedText(settings: Record<string, unknown>, objects: { name: string; unchecked?: string[] }[], stride: number): string {
  const parts = stride > 1 ? [`only every ${ordinal(stride)} frame was checked`] : [];
  if (settings['within'] === false) parts.push('pairs within one mesh were not tested');
  else if (settings['between'] === false && objects.length > 1) parts.push('pairs of two meshes were not tested');
  for (const { name, unchecked = [] } of objects) parts.push(...unchecked.map((text) => (objects.length > 1 ? `${name}: ${text}` : text)));
  return ignoredText(settings) + parts.map((part) => `; ${part}`).join('');
}

export function verdictOf(found: Found): Verdict {
  const { text, kind } = verdictOfTested(found);
  return { text: text + (found.state === 'done' ? found.untested : ''), kind };
}

function verdictOfTested(found: Found): Verdict {
  const { start, pairs } = found;
  if (found.state === 'running') return running(found);
  if (found.state !== 'done') return stopped(found);
  const steps = stepsText(found);
  const can = found.statistical ? 'Statistical, can miss: ' : '';
  const contacts = `${pairsText(found)} in ${grouped(found.colliding)} of ${steps}`;
  if (found.poses && pairs > 0) return { text: `${can}${found.single ? `${pairsText(found)} in the one frame` : contacts}`, kind: 'hit' };
  if (found.poses) return { text: `${can || 'Proven free: '}nothing crosses in ${found.single ? 'the one frame' : `any of ${steps}`}`, kind: can ? 'run' : 'free' };
  if (found.single && start) return single(start, pairs);
  if (start && start.crossings > 0) return { text: `${startText(start)}; ${can.toLowerCase()}${pairs > 0 ? contacts : `no new contact in ${steps}`}`, kind: 'hit' };
  if (pairs > 0) return { text: `${can}${contacts}${start ? '' : `; ${kStartNotTested}`}`, kind: 'hit' };
  if (!start) return { text: `${can}${can ? 'no' : 'No'} contact in ${steps}; ${kStartNotTested}`, kind: 'run' };
  if (found.statistical) return { text: `${can}no collision found in ${steps}`, kind: 'run' };
  return { text: `Proven free of collisions${found.assumed}: frame ${start.frame} and ${found.total === 1 ? 'the step from it' : `all ${counted(found.total, 'step')}`}`, kind: 'free' };
}
