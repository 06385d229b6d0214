// The overall result of a check: while it runs, and where it did not reach its end. What it found at its end, the program says.
import { counted, grouped } from './format';
import { wordsOf } from './words';

/** The answer for the first frame. */
export interface Start {
  frame: number;
  crossings: number; // pairs of triangles
  listed: number; // of them, listed and marked
  ms: { total: number };
}

/** The program's words for a check that has ended. */
export interface Answer {
  text: string;
  kind: 'free' | 'found' | 'limited';
  numbers: string; // steps, pairs and triangles, where the text leaves them out
  whole: boolean; // nothing was left out; else the text names it
}

export interface Found {
  state: 'running' | 'done' | 'stopped' | 'failed' | 'gone';
  done: number;
  total: number; // expected steps
  pairs: number;
  start: Start | null; // null if not tested, or not yet
  single: boolean; // one frame, whose only step has no motion
  poses: boolean; // a static check, whose steps are poses
  assumed: string; // what files were taken for, ' between 3 frames of one mesh'; it follows what was checked
  answer: Answer | null; // at the end
}

export type Kind = 'run' | 'free' | 'hit' | 'stopped';

export interface Verdict {
  text: string;
  kind: Kind;
}

const kKinds: Record<Answer['kind'], Kind> = { free: 'free', found: 'hit', limited: 'run' };

export const startText = ({ frame, crossings }: Start, single = false): string =>
  crossings === 0 ? `Nothing crosses in frame ${frame}` : `Frame ${frame} ${single ? 'has' : 'starts with'} ${counted(crossings, 'crossing pair')} of triangles`;

const stepsText = ({ poses, total, assumed }: Found): string => counted(total, wordsOf(poses).step) + assumed;

export const stoppedText = (found: Found): string => `Stopped at ${grouped(found.done)} of ${stepsText(found)}`;

export const sayAnswer = ({ text, kind }: Answer): Verdict => ({ text: text.replace(/\.$/, ''), kind: kKinds[kind] });

export function verdictOf(found: Found): Verdict {
  const { answer, done, pairs, poses, single, start, state } = found;
  if (answer && state === 'done') return sayAnswer(answer);
  const crosses = (start?.crossings ?? 0) > 0;
  const hit = crosses || pairs > 0;
  if (state === 'running' || state === 'done') {
    const checking = single ? 'Checking' : `Checking: ${grouped(done)} of ${stepsText(found)}, ${counted(pairs, 'pair')} so far`;
    return { text: crosses ? `${startText(start!, single)}. ${checking}` : checking, kind: hit ? 'hit' : 'run' };
  }
  const parts = [stoppedText(found)];
  if (crosses) parts.push(startText(start!, single).replace('Frame', 'frame'));
  if (pairs > 0) parts.push(`${counted(pairs, `${wordsOf(poses).colliding} pair`)} until then`);
  if (parts.length === 1) parts.push('the rest is unknown');
  return { text: parts.join('; '), kind: hit ? 'hit' : 'stopped' };
}
