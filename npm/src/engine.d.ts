// The library as WebAssembly, which the preset web builds (web/package_engine.cpp). Pointers and handles are numbers.
export interface Engine {
  HEAPU8: Uint8Array;
  HEAPU32: Uint32Array;
  HEAPF64: Float64Array;
  _malloc(bytes: number): number;
  _free(at: number): void;
  UTF8ToString(at: number): string;
  stringToUTF8(text: string, at: number, bytes: number): void;
  lengthBytesUTF8(text: string): number;
  _foldproof_answer(): number;
  _foldproof_arrays(): number;
  _foldproof_meshes(): number;
  _foldproof_drop_meshes(meshes: number): void;
  _foldproof_add_mesh(meshes: number, name: number, triangles: number, count: number, vertices: number, parts: number, partOfTriangle: number): number;
  _foldproof_add_frame(meshes: number, x: number): number;
  _foldproof_open_check(meshes: number, settings: number): number;
  _foldproof_drop_check(check: number): void;
  _foldproof_advance(check: number): number;
  _foldproof_open_checker(meshes: number): number;
  _foldproof_drop_checker(checker: number): void;
  _foldproof_check_step(checker: number, x0: number, x1: number, settings: number): number;
  _foldproof_check_pose(checker: number, x: number, settings: number): number;
}
export default function createEngine(): Promise<Engine>;
