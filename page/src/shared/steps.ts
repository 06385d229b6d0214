// The program's data for a step; the same in the page and in the report.

export interface Step {
  number: number;
  frame: number;
  next_frame: number;
  substep: number;
  vertex_face: number;
  edge_edge: number;
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

export const collisionsOf = (step: Step): number => step.vertex_face + step.edge_edge;

/** The start of a step, in frames of the motion. */
export const startOf = (step: Step, substeps: number): number =>
  step.frame + (step.substep * (step.next_frame - step.frame)) / substeps;

export const stepText = (step: Step, substeps: number): string =>
  `frame ${step.frame} to ${step.next_frame}` + (substeps > 1 ? `, part ${step.substep + 1} of ${substeps}` : '');
