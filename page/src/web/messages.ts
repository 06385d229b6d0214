// What the page and its worker say to each other.

/** A file and its path below the dropped folder. */
export interface InputFile {
  path: string;
  blob: Blob;
}

export interface Settings {
  thickness: number; // mesh units
  substeps: number;
  static: boolean; // each frame by itself
  fps: number; // glTF: frames per second
  seams: 'by_format' | 'always' | 'never'; // which vertices become one
  clip: string; // glTF: the animation; empty: the longest
  meshes: string; // what several meshes are: 'sequence', 'separate', or 'names', by which they are either
}

export type Request =
  | { id: number; kind: 'open'; files: InputFile[]; settings: Settings }
  | { id: number; kind: 'get'; path: string }
  | { id: number; kind: 'report' }
  | { id: number; kind: 'stop' };

export interface Answer {
  id: number;
  status: number;
  body: ArrayBuffer;
}

/** The share of a repair that is done; meanwhile nothing is answered. */
export interface Repairing {
  share: number;
}

/** The error of a check that cannot go on. */
export const checkFailed = (message: string): Error => new Error(`the check: failed: ${message}; please report this`);
