// The worker that reads and checks a motion.
import { repairProgress, type Source } from '../view/api';
import { checkFailed, type Answer, type InputFile, type Repairing, type Request, type Settings } from './messages';
import EngineWorker from './worker?worker&inline';

type Unnumbered = Request extends infer R ? (R extends Request ? Omit<R, 'id'> : never) : never;

export class Engine {
  private readonly worker = new EngineWorker();
  private readonly waiting = new Map<number, { resolve: (answer: Answer) => void; reject: (error: Error) => void }>();
  private asked = 0;

  constructor() {
    this.worker.onmessage = ({ data }: MessageEvent<Answer | Repairing>) => {
      if ('share' in data) return repairProgress(data.share);
      this.waiting.get(data.id)?.resolve(data);
      this.waiting.delete(data.id);
    };
    this.worker.onerror = ({ message }) => {
      for (const { reject } of this.waiting.values()) reject(checkFailed(message));
      this.waiting.clear();
    };
  }

  private ask(request: Unnumbered): Promise<Answer> {
    const id = ++this.asked;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.worker.postMessage({ ...request, id });
    });
  }

  /** Reads the files. Throws an error whose message says what is wrong. */
  async open(files: InputFile[], settings: Settings): Promise<void> {
    const { status, body } = await this.ask({ kind: 'open', files, settings });
    if (status !== 200) throw new Error((JSON.parse(new TextDecoder().decode(body)) as { error: string }).error);
  }

  readonly source: Source = async (path) => {
    const { status, body } = await this.ask({ kind: 'get', path });
    return new Response(body, { status });
  };

  /** The report of a check that has ended, as one HTML file; null before. */
  async report(): Promise<Blob | null> {
    const { status, body } = await this.ask({ kind: 'report' });
    return status === 200 ? new Blob([body], { type: 'text/html' }) : null;
  }

  /** Ends the check after the current step. */
  stop(): void {
    void this.ask({ kind: 'stop' });
  }

  end(): void {
    this.worker.terminate();
  }
}
