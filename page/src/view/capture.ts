// Saves pictures and videos of the picture.
import { el } from '../shared/dom';

const kFramesPerSecond = 30;
const kTypes = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'];

export function save(blob: Blob, name: string): void {
  const link = el('a', { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** A name for a file from the title of the motion. */
export const nameOf = (title: string, end: string): string => `${title.replace(/\.\w+$/, '').replace(/[^\w.-]+/g, '_') || 'foldproof'}${end}`;

export async function savePicture(picture: Promise<Blob | null>, title: string, position: string): Promise<void> {
  const blob = await picture;
  if (blob) save(blob, nameOf(title, `_${position}.png`));
}

/** Records what the canvas shows until it is stopped. */
export class Recorder {
  private recorder: MediaRecorder | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly title: string,
    private readonly changed: (recording: boolean) => void,
  ) {}

  get recording(): boolean {
    return this.recorder !== null;
  }

  /** False if the browser cannot record. */
  start(): boolean {
    const type = kTypes.find((one) => typeof MediaRecorder !== 'undefined' && MediaRecorder.isTypeSupported(one));
    if (!type) return false;
    const parts: Blob[] = [];
    this.recorder = new MediaRecorder(this.canvas.captureStream(kFramesPerSecond), { mimeType: type, videoBitsPerSecond: 12e6 });
    this.recorder.addEventListener('dataavailable', ({ data }) => parts.push(data));
    this.recorder.addEventListener('stop', () => save(new Blob(parts, { type: 'video/webm' }), nameOf(this.title, '.webm')));
    this.recorder.start();
    this.changed(true);
    return true;
  }

  stop(): void {
    this.recorder?.stop();
    this.recorder = null;
    this.changed(false);
  }
}
