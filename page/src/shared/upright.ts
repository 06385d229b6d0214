// Which axis of a motion points up, and from where it is best seen: the rules of src/picture/upright.h. The cases in
// tests/picture/upright.json hold for both.

export type Up = 'y' | 'z';
export type Vector = readonly [number, number, number];
/** The box around a pose. */
export interface Box {
  min: Vector;
  max: Vector;
}

const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const norm = (a: Vector): number => Math.hypot(...a);

/** How far values move. */
const moved = (values: number[]): number => Math.max(...values) - Math.min(...values);

/**
 * Guesses the axis that points up: z if the motion stands on a ground across z, and on none across y; else y. It stands on a
 * ground if its lowest point moves by at most 5 % of the motion's size, a third of what it moves along the other axis, while
 * something does move along this one.
 */
export function guessUp(poses: readonly Box[]): Up {
  const kAxes = [0, 1, 2] as const;
  const lowest = kAxes.map((axis) => moved(poses.map(({ min }) => min[axis])));
  const highest = kAxes.map((axis) => moved(poses.map(({ max }) => max[axis])));
  const size = Math.max(...kAxes.map((axis) => Math.max(...poses.map(({ max }) => max[axis])) - Math.min(...poses.map(({ min }) => min[axis]))));
  const standsAcross = (axis: 1 | 2, other: 1 | 2): boolean =>
    Math.max(lowest[axis]!, highest[axis]!) > 1e-3 * size && lowest[axis]! <= 0.05 * size && 3 * lowest[axis]! <= lowest[other]!;
  return standsAcross(2, 1) && !standsAcross(1, 2) ? 'z' : 'y';
}

/** Turns a direction in a scene with y up into the same direction in a scene with `up`. */
export const upright = ([x, y, z]: Vector, up: Up): Vector => (up === 'y' ? [x, y, z] : [x, -z, y]);

/** To the eye: from the front, slightly from the right and from above. */
export const defaultDirection = (up: Up): Vector => upright([0.4, 0.3, 1], up);

/** To the eye, along a normal, but from at most 60 degrees above or below, where the picture would not be upright. */
export function directionAlong(normal: Vector, up: Up): Vector {
  const vertical = upright([0, 1, 0], up);
  const height = dot(normal, vertical);
  const length = norm(normal);
  const limit = Math.sin(Math.PI / 3) * length;
  if (Math.abs(height) <= limit) return normal;
  let level: Vector = [normal[0] - height * vertical[0], normal[1] - height * vertical[1], normal[2] - height * vertical[2]];
  // From straight above, the front stays below.
  if (norm(level) < 1e-6 * length) level = upright([0, 0, 1], up);
  const across = (0.5 * length) / norm(level);
  const along = Math.sign(height) * limit;
  return [across * level[0] + along * vertical[0], across * level[1] + along * vertical[1], across * level[2] + along * vertical[2]];
}
