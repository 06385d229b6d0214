// Runs the engine: reads the files, checks step by step, and answers requests between the steps.
import createFoldproof, { type Engine } from 'foldproof-engine';
import { unzipSync, zlibSync } from 'fflate';
import { argumentsOf } from './arguments';
import { checkFailed, type Answer, type InputFile, type Repairing, type Request, type Settings } from './messages';

const kIdleMs = 100;
const kFolder = '/motion';
const kReport = '/report.html'; // there from the end of the check on

const engine = createFoldproof({ deflate: zlibSync, repairing: (share) => self.postMessage({ share } satisfies Repairing) });
const turns = new MessageChannel(); // lets requests in between two steps
let failed: Error | null = null; // what broke off the check; from then on the engine answers nothing else

const bytesOf = (text: string): ArrayBuffer => new TextEncoder().encode(text).buffer as ArrayBuffer;
const messageOf = (error: unknown): string => (error instanceof Error ? error.message : String(error));
const failure = (id: number, line: string): Answer => ({ id, status: 500, body: bytesOf(JSON.stringify({ error: line })) });

/** The arrays of an NPZ. */
function arraysOf(path: string, bytes: Uint8Array): Record<string, Uint8Array> {
  try {
    return unzipSync(bytes, { filter: ({ name }) => /^[^/]+\.npy$/.test(name) });
  } catch {
    throw new Error(`${path}: is not a complete ZIP archive; save it again`);
  }
}

async function store({ FS }: Engine, { path, blob }: InputFile): Promise<void> {
  const at = `${kFolder}/${path}`;
  FS.mkdirTree(at.slice(0, at.lastIndexOf('/')));
  const bytes = new Uint8Array(await blob.arrayBuffer());
  FS.writeFile(at, bytes, { canOwn: true });
  if (!/\.npz$/i.test(path)) return;
  FS.mkdirTree(`${at}.arrays`);
  for (const [name, array] of Object.entries(arraysOf(path, bytes))) FS.writeFile(`${at}.arrays/${name}`, array, { canOwn: true });
}

async function open(engine: Engine, files: InputFile[], settings: Settings): Promise<number> {
  for (const file of files) await store(engine, file);
  engine.FS.chdir(kFolder);
  const names = argumentsOf(files.map(({ path }) => path));
  const request = { ...names, ...settings, command: `in the browser: ${[...names.files, ...names.models].join(' ')}` };
  const status = engine.ccall('foldproof_open', 'number', ['string'], [JSON.stringify(request)]);
  if (status === 200) turn();
  return status;
}

function turn(): void {
  void engine
    .then((engine) => {
      if (engine._foldproof_advance() > 0) turns.port2.postMessage(null);
      else setTimeout(turn, kIdleMs);
    })
    .catch((error: unknown) => (failed = checkFailed(messageOf(error))));
}

function answered(engine: Engine, id: number, status: number): Answer {
  const at = engine._foldproof_body();
  const body = engine.HEAPU8.slice(at, at + engine._foldproof_body_size()).buffer as ArrayBuffer;
  return { id, status, body };
}

async function answer(request: Request): Promise<Answer> {
  const loaded = await engine;
  if (failed) throw failed;
  switch (request.kind) {
    case 'open':
      return answered(loaded, request.id, await open(loaded, request.files, request.settings));
    case 'get':
      return answered(loaded, request.id, loaded.ccall('foldproof_get', 'number', ['string'], [`/api/${request.path}`]));
    case 'report': {
      const found = loaded.FS.analyzePath(kReport).exists;
      return { id: request.id, status: found ? 200 : 404, body: found ? (loaded.FS.readFile(kReport).buffer as ArrayBuffer) : new ArrayBuffer(0) };
    }
    case 'stop':
      loaded._foldproof_stop();
      return { id: request.id, status: 200, body: new ArrayBuffer(0) };
  }
}

turns.port1.onmessage = turn;
self.onmessage = async ({ data: request }: MessageEvent<Request>) => {
  let answer_: Answer;
  try {
    answer_ = await answer(request);
  } catch (error) {
    answer_ = failure(request.id, messageOf(error));
  }
  self.postMessage(answer_, { transfer: [answer_.body] });
};
