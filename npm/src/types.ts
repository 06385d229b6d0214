/** Three numbers for each row: one after the other, or a row as an array of its own. */
export type Rows = ArrayLike<number> | ArrayLike<ArrayLike<number>>;

/** A mesh and its frames. */
export interface Motion {
  /** Triangles, as ids of three vertices each. Ids count from 0. */
  faces: Rows;
  /** For each frame, the position of every vertex, in mesh units. A generator's frames are taken one at a time. */
  frames: Iterable<Rows> | AsyncIterable<Rows>;
  /** What contacts call it. */
  name?: string;
  /** For each triangle, the name of the part that it belongs to; contacts name their sides by them. */
  parts?: ArrayLike<string>;
}

/** A mesh in one pose. */
export interface Mesh {
  faces: Rows;
  /** Of every vertex, in mesh units; any pose. */
  positions: Rows;
}

export interface StepSettings {
  /** Find collisions of each object with itself. Default: true. */
  within?: boolean;
  /** Find collisions of every two objects. Default: true. */
  between?: boolean;
  /** A distance up to this is a collision, in mesh units. Default: 0. */
  thickness?: number;
  /** How far beyond the thickness a reported pair may be, in mesh units. Default: 0, for 2^-30 of the scene's size. */
  tolerance?: number;
  /** Prove parts free of collisions where that is faster than testing them. Never changes an answer. Default: true. */
  certificates?: boolean;
  /** List at most this many pairs of each kind in a step, those with the smallest ids; all are counted. Default: ten million. */
  maxListed?: number;
}

export interface CheckSettings extends StepSettings {
  /** Find the triangles that cross in each frame, and ignore the motion between frames. Default: false. */
  static?: boolean;
  /** Do not test the first frame for triangles that cross. Default: false. */
  stepsOnly?: boolean;
  /** Straight parts that each step between two frames is divided into. Default: 1. */
  substeps?: number;
  /** Join what collides into contacts. Default: true. */
  contacts?: boolean;
  /** Called with the share that is done, from 0 to 1. */
  onProgress?: (share: number) => void;
  /** Ends the check; its promise is rejected with the signal's reason. */
  signal?: AbortSignal;
}

/** Vertices that touch faces. Element k of each array belongs to pair k. */
export interface VertexFacePairs {
  vertexObject: Uint32Array;
  vertex: Uint32Array;
  faceObject: Uint32Array;
  face: Uint32Array;
  /** Time of impact, in [0, 1] of the step; no collision before it, proven. */
  toi: Float64Array;
  /** 1 where rounding does not let the pair be called free, and it counts as colliding. */
  undecided: Uint8Array;
}

/** Edges that touch edges. a and b have two vertex ids for each pair. */
export interface EdgeEdgePairs {
  objectA: Uint32Array;
  a: Uint32Array;
  objectB: Uint32Array;
  b: Uint32Array;
  toi: Float64Array;
  undecided: Uint8Array;
}

/** Triangles that cross each other. */
export interface Crossings {
  objectA: Uint32Array;
  triangleA: Uint32Array;
  objectB: Uint32Array;
  triangleB: Uint32Array;
}

/** Every pair that touches during a step, sorted by ids. */
export interface StepResult {
  /** Nothing touches. */
  clean: boolean;
  /** How many there are, listed or not. */
  vertexFaceCount: number;
  edgeEdgeCount: number;
  vertexFace: VertexFacePairs;
  edgeEdge: EdgeEdgePairs;
  /** In [0, 1]; 1 where nothing collides. */
  earliestToi: number;
  /** What was used, in mesh units. */
  tolerance: number;
  milliseconds: number;
  /** For each object, a number for each of its triangles: 1 where it collides, or one of its vertices or edges does. */
  collidingFaces: Uint8Array[];
}

/** Every two triangles that cross in a pose, decided exactly, sorted by ids. */
export interface StaticResult {
  /** Nothing crosses. */
  clean: boolean;
  /** How many there are, listed or not. */
  crossingCount: number;
  crossings: Crossings;
  milliseconds: number;
  collidingFaces: Uint8Array[];
}

/** Which step of a motion: from a frame to the next one, or a part of that. */
export interface StepPlace {
  number: number;
  frame: number;
  nextFrame: number;
  substep: number;
}

/** A contact in one frame in which its triangles cross. */
export interface ContactFrame {
  time: number;
  /** Pairs of triangles. */
  crossings: number;
  /** That cross or are inside, on both sides. */
  triangles: number;
  curveLength: number;
  /** Whether all curves are closed. */
  closed: boolean;
  /** Inside the other surface, of each side; null where there is no region. */
  area: [number | null, number | null];
  depth: number | null;
}

/** One of the two surfaces of a contact; its triangles in the worst frame. */
export interface ContactSide {
  object: number;
  name: string;
  triangles: number[];
  /** Those of them that lie entirely inside. */
  inside: number[];
}

/** What collides and crosses in one place, joined over time. Times are frames, with fractions between them; lengths are mesh units. */
export interface Contact {
  number: number;
  /** Numbers of contacts that became a part of it. */
  joined: number[];
  sides: [ContactSide, ContactSide];
  /** Contacts of the same two parts or objects have one group; the worst is 0. */
  group: number;
  /** How often the group occurs: "4 times", "in 3 places"; empty for once. */
  often: string;
  /** Its sides are two objects, or parts. */
  named: boolean;
  /** Both sides are the same piece of a surface. */
  folded: boolean;
  fromStart: boolean;
  healed: boolean;
  firstTime: number;
  lastTime: number;
  /** Colliding pairs of features, over all steps. */
  pairs: number;
  depth: number | null;
  /** The depth is a lower bound, as both surfaces are open. */
  atLeast: boolean;
  /** In the worst frame it only touches. */
  touching: boolean;
  /** Time of the worst frame; null where it only touches between frames, or it is not known what crosses (unknownFrames). */
  worst: number | null;
  /** Where it is in the worst frame, the box of what takes part, and the direction out. */
  point: [number, number, number];
  box: [[number, number, number], [number, number, number]];
  normal: [number, number, number];
  frames: ContactFrame[];
  /** In which the surfaces cross, as polylines; a closed one repeats its first point. */
  curves: [number, number, number][][];
}

/** Answer of a whole check. */
export interface CheckResult<Step = StepResult> {
  /** No triangles cross in the first frame and nothing collides in any step: nothing intersects at any time. With stepsOnly or static only what they test counts. */
  clean: boolean;
  /** Pairs that collide, over all steps. */
  collisions: number;
  /** How many of them are listed, and can be in contacts: fewer where maxListed left some out. */
  listed: number;
  /** Pairs of triangles that cross in the first frame; null with stepsOnly or static. */
  startsCrossing: number | null;
  startCrossings: Crossings | null;
  steps: (StepPlace & Step)[];
  /** The worst first. Empty with contacts: false. */
  contacts: Contact[];
  /** Frames of which it is not known what crosses: more pairs than maxListed, or stepsOnly. */
  unknownFrames: number;
  /** The largest of a step, in mesh units. */
  tolerance: number;
}

/** Why a mesh, a motion or a setting was refused: one line. */
export class FoldproofError extends Error {
  override name = 'FoldproofError';

  /** where: the argument and the place in it; problem: what is wrong; remedy: what to do about it. */
  constructor(
    readonly where: string,
    readonly problem: string,
    readonly remedy: string,
  ) {
    super(`${where}: ${problem}; ${remedy}`);
  }
}
