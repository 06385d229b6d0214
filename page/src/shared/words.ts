// What a check finds, in words: collisions in the steps of a motion, or crossings in frames that are poses of their own.

export interface Words {
  step: string; // what is checked, one after the other
  collisions: string;
  colliding: string; // pairs or triangles
  collides: string;
  orStart: string; // where else the way back leads
}

const kMotion: Words = { step: 'step', collisions: 'collisions', colliding: 'colliding', collides: 'collides', orStart: ', or the start if it crosses' };
const kPoses: Words = { step: 'frame', collisions: 'crossings', colliding: 'crossing', collides: 'crosses', orStart: '' };

/** Whether a check was static: each of its steps is a pose. */
export const isStatic = (settings: Record<string, unknown>): boolean => settings['static'] === true;

export const wordsOf = (poses: boolean): Words => (poses ? kPoses : kMotion);

export const capital = (text: string): string => text[0]!.toUpperCase() + text.slice(1);

export const kStartNotTested = 'crossings from the start were not tested (--steps-only)';
export const kBetweenNotTested = 'Each frame is tested by itself; what happens between frames is not tested (--static).';
