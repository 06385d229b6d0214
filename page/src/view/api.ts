// The program's HTTP interface, documented in docs/viewer.md.
import type { Contact } from '../shared/contact';
import type { Step } from '../shared/steps';
import type { Answer, Start } from '../shared/verdict';

export interface ModelInfo {
  name: string;
  modes: number; // 0: it has learned no shapes
  deviations: number[];
  energy: number[];
  key_points: number[];
  poses: number;
}

export interface ObjectInfo {
  name: string;
  vertices: number;
  triangles: number;
  levels: number;
  unchecked: string[]; // what of it was not checked
  notes: string[]; // on what its reader left out or assumed
  model: ModelInfo | null;
}

export interface SceneInfo {
  program: string;
  version: string;
  title: string;
  frames: number;
  frame_numbers: number[];
  frame_names: string[]; // of poses, whose files have names; else empty
  fps: number;
  substeps: number;
  steps: number;
  assumed: string; // what files were taken for, to follow what was checked in the verdict
  objects: ObjectInfo[];
  parts: { object: number; name: string }[]; // of all objects
  center: number[]; // positions of vertices are relative to it
  low: number[];
  high: number[];
  settings: Record<string, unknown>;
  reasons: string[];
  cancels: boolean; // a repair can be cancelled
}

/** Of all objects, mesh units. */
export interface Bounds {
  low: number[];
  high: number[];
}

export interface StepsAnswer {
  state: 'running' | 'done' | 'stopped' | 'failed';
  error?: string | null;
  start: Start | null; // null if not tested, or not yet
  verdict: Answer | null; // at the end
  done: number;
  total: number;
  steps: (Step & Bounds)[];
}

export interface ContactsAnswer {
  searched: boolean;
  unknown_frames: number;
  notices: string[]; // to be read before the contacts
  total: number;
  items: Contact[];
}

/** A pair of features that collide in a step, or (tt) of triangles that cross in a pose or in the first frame. */
export interface Pair {
  kind: 'vf' | 'ee' | 'tt';
  object_a: number;
  a: number[];
  object_b: number;
  b: number[];
  toi: number;
  answer: 'hit' | 'undecided' | 'crossing';
  point: number[];
}

export interface Radius {
  state: 'computing' | 'done' | 'failed';
  progress?: number;
  radius?: number;
  share?: number;
  uncertified?: number; // pairs of patches that the radius leaves out
  uncertified_triangles?: number[];
  error?: string | null;
}

/** An error that the program answered, in its words. */
export class ApiError extends Error {}
/** The program did not answer at all. */
export class GoneError extends Error {}

/** Answers a request for the data of the scene. */
export type Source = (path: string, signal?: AbortSignal) => Promise<Response>;

const kLongestAddress = 4000;

// Parameters that are too long for an address stand in the body.
let source: Source = (path, signal) => {
  if (path.length <= kLongestAddress) return fetch(`/api/${path}`, signal ? { signal } : {});
  const [start, parameters] = path.split('?') as [string, string];
  return fetch(`/api/${start}`, { method: 'POST', body: parameters });
};

/** Where the data comes from, if not from the program that serves the page. */
export function useSource(other: Source): void {
  source = other;
}

async function get(path: string, signal?: AbortSignal): Promise<Response> {
  let response: Response;
  try {
    response = await source(path, signal);
  } catch (error) {
    if (signal?.aborted) throw error;
    throw new GoneError('The program no longer answers.');
  }
  if (response.ok) return response;
  let text = `The program answered with status ${response.status}.`;
  try {
    text = String(((await response.json()) as { error?: unknown }).error ?? text);
  } catch {
    // Not JSON: report the status.
  }
  throw new ApiError(text);
}

async function body<T>(read: Promise<T>): Promise<T> {
  try {
    return await read;
  } catch {
    throw new GoneError('The program broke off in the middle of an answer.');
  }
}

export async function getJson<T>(path: string, signal?: AbortSignal): Promise<T> {
  const response = await get(path, signal);
  return (await body(response.json())) as T;
}

export async function getFloats(path: string, signal?: AbortSignal): Promise<Float32Array> {
  const response = await get(path, signal);
  return new Float32Array(await body(response.arrayBuffer()));
}

export async function getBlob(path: string): Promise<Blob> {
  const response = await get(path);
  return body(response.blob());
}

let repairing: (share: number) => void = () => undefined;

/** Where the source answers nothing while it repairs, it says how far it is. */
export function onRepairProgress(listener: (share: number) => void): void {
  repairing = listener;
}
export const repairProgress = (share: number): void => repairing(share);

export async function getIndices(path: string): Promise<Uint32Array> {
  const response = await get(path);
  return new Uint32Array(await body(response.arrayBuffer()));
}

/** Fills the first `length` bytes of `target` as they arrive. */
export async function getInto(path: string, target: Uint8Array, length: number): Promise<void> {
  const response = await get(path);
  const reader = response.body!.getReader();
  let at = 0;
  for (;;) {
    const { done, value } = await body(reader.read());
    if (done) break;
    if (at + value.length > length) throw new ApiError(`${path} is longer than ${length} bytes`);
    target.set(value, at);
    at += value.length;
  }
  if (at !== length) throw new ApiError(`${path} has ${at} bytes and not ${length}`);
}
