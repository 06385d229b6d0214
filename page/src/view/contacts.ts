// The contacts that the check found, the worst first. They are known when it has ended.
import { short } from '../shared/format';
import { namesText, placeText, touchText, worstOf, type Contact, type ContactFrame } from '../shared/contact';
import { ApiError, getJson, type ContactsAnswer, type SceneInfo } from './api';

const kPage = 1000;

export class Contacts {
  items: Contact[] = [];
  total = 0;
  unknownFrames = 0;
  notices: string[] = []; // to be read before the list
  state: 'waiting' | 'loading' | 'known' | 'none' = 'waiting'; // none: not looked for, or the check was stopped
  private readonly details = new Map<number, Contact>();

  constructor(
    private readonly scene: SceneInfo,
    private readonly changed: () => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  /** Fetches the list, once the check has ended. */
  async load(): Promise<void> {
    if (this.state !== 'waiting') return;
    this.state = 'loading';
    try {
      const { searched, unknown_frames, notices, total, items } = await getJson<ContactsAnswer>(`contacts?limit=${kPage}`);
      this.items = items;
      this.total = total;
      this.unknownFrames = unknown_frames;
      this.notices = notices;
      this.state = searched ? 'known' : 'none';
    } catch (error) {
      this.state = error instanceof ApiError ? 'none' : 'waiting';
      if (this.state === 'waiting') this.failed(error);
    }
    this.changed();
  }

  /** A contact of the list with its triangles and curves. */
  async detail(index: number): Promise<Contact> {
    let contact = this.details.get(index);
    if (!contact) {
      contact = await getJson<Contact>(`contacts/${index}`);
      this.details.set(index, contact);
    }
    return contact;
  }

  /** The index of the contact that begins first. */
  get first(): number {
    let best = 0;
    this.items.forEach((contact, k) => {
      if (contact.first_time < this.items[best]!.first_time) best = k;
    });
    return best;
  }

  /** A frame of the motion as a position of the timeline, which counts the selected frames. */
  positionOf(time: number): number {
    const numbers = this.scene.frame_numbers;
    let k = 0;
    while (k + 1 < numbers.length && numbers[k + 1]! <= time) ++k;
    const [from, to] = [numbers[k] ?? 0, numbers[k + 1] ?? numbers[k] ?? 0];
    return to > from ? k + (time - from) / (to - from) : k;
  }

  /** Those that cross, or touch, near a position, with what they are there. */
  at(position: number): { index: number; contact: Contact; frame: ContactFrame | null }[] {
    const found: { index: number; contact: Contact; frame: ContactFrame | null }[] = [];
    this.items.forEach((contact, index) => {
      if (position < this.positionOf(contact.first_time) - 0.5 || position > this.positionOf(contact.last_time) + 0.5) return;
      let nearest: ContactFrame | null = null;
      for (const frame of contact.frames) {
        if (!nearest || Math.abs(this.positionOf(frame.time) - position) < Math.abs(this.positionOf(nearest.time) - position)) nearest = frame;
      }
      found.push({ index, contact, frame: nearest });
    });
    return found;
  }

  private get unit(): string {
    const unit = this.scene.settings['unit'];
    return typeof unit === 'string' && unit !== '' ? ` ${unit}` : '';
  }

  /** "0.0843 cm deep", or how long the curve is where there is no depth. */
  sizeText(contact: Contact, frame = worstOf(contact)): string {
    if (!frame) return touchText(this.unknownFrames, this.scene.frames === 1);
    if (frame.depth !== null) return `${short(frame.depth)}${this.unit} deep`;
    return `curve ${short(frame.curve_length)}${this.unit} long`;
  }

  /** The names of the two sides, where they differ. */
  sideNames({ sides }: Contact): string[] {
    const names = sides.map(({ name }) => name);
    return names[0] === names[1] ? ['First side', 'Second side'] : names;
  }

  /** The names of the two sides as one; what is within the only object is named by its place. */
  title(contact: Contact): string {
    const { objects } = this.scene;
    const within = contact.sides.every(({ name }) => name === objects[0]!.name);
    return objects.length === 1 && within ? `at ${placeText(contact)}` : namesText(contact);
  }
}

/** The frames in which a contact crosses, as text. */
export function framesText({ frames, first_time }: Contact): string {
  if (frames.length === 0) return `frame ${short(first_time)}`;
  const [from, to] = [short(frames[0]!.time), short(frames.at(-1)!.time)];
  return from === to ? `frame ${from}` : `frames ${from}–${to}`;
}
