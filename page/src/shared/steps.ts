// The program's data for a step; the same in the page and in the report.

/** A step of a motion, or a pose of a static check, whose two frames are the same. */
export interface Step {
  number: number;
  frame: number;
  next_frame: number;
  substep: number;
  vertex_face: number;
  edge_edge: number;
  /** Pairs of triangles, in a pose. */
  crossings: number;
  /** Triangles that cross or are inside at its begin and its end; null where that is not known. */
  inside: [number | null, number | null];
  /** How many collisions are listed and marked. */
  listed: number;
  undecided: number;
  toi: number;
  tolerance: number;
  node_tests: number;
  certificate_tests: number;
  certificate_passes: number;
  leaf_pairs: number;
  candidates: number;
  reasons: number[];
  ms: { total: number; update: number; traverse: number; narrow: number };
}

export const collisionsOf = (step: Step): number => step.vertex_face + step.edge_edge + step.crossings;

/** The start of a step, in frames of the motion. */
const startOf = (step: Step, substeps: number): number =>
  step.frame + (step.substep * (step.next_frame - step.frame)) / substeps;

const standsStill = (step: Step): boolean => step.frame === step.next_frame;

/** The interval in which a step is drawn, in frames; that of a pose is centered on its frame. `stride`: between two selected frames. */
export function spanOf(step: Step, substeps: number, stride: number): [number, number] {
  if (standsStill(step)) return [step.frame - stride / 2, step.frame + stride / 2];
  const from = startOf(step, substeps);
  return [from, from + (step.next_frame - step.frame) / substeps];
}

export function stepText(step: Step, substeps: number): string {
  if (standsStill(step)) return `frame ${step.frame}`;
  return `frame ${step.frame} to ${step.next_frame}` + (substeps > 1 ? `, part ${step.substep + 1} of ${substeps}` : '');
}
