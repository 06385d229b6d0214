// What ./dev web builds before the page: the library as WebAssembly (web/), and a generated motion.
declare module 'foldproof-engine' {
  export interface Engine {
    FS: {
      mkdirTree(path: string): void;
      writeFile(path: string, bytes: Uint8Array, options: { canOwn: boolean }): void;
      readFile(path: string): Uint8Array;
      analyzePath(path: string): { exists: boolean };
      chdir(path: string): void;
    };
    HEAPU8: Uint8Array;
    ccall(name: string, result: 'number', types: string[], values: unknown[]): number;
    _foldproof_advance(): number;
    _foldproof_stop(): void;
    _foldproof_body(): number;
    _foldproof_body_size(): number;
  }
  export default function createFoldproof(options: { deflate: (bytes: Uint8Array) => Uint8Array; repairing: (share: number) => void }): Promise<Engine>;
}

declare module 'foldproof-sample?inline' {
  const dataUrl: string;
  export default dataUrl;
}
