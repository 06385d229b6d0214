// The contacts that the check found, the worst first. They are known when it has ended.
import { short } from '../shared/format';
import { depthText, groupsOf, namesText, placeText, touchText, worstOf, type Contact, type ContactFrame, type Group } from '../shared/contact';
import type { Up } from '../shared/upright';
import { ApiError, getJson, type ContactsAnswer, type SceneInfo } from './api';

const kPage = 1000;

export class Contacts {
  items: Contact[] = [];
  groups: Group[] = []; // of the items, by the same two parts
  total = 0;
  unknownFrames = 0;
  notices: string[] = []; // to be read before the list
  state: 'waiting' | 'loading' | 'known' | 'none' = 'waiting'; // none: not looked for, or the check was stopped
  private readonly details = new Map<string, Contact>();

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
      this.groups = groupsOf(items);
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

  /** A contact of the list with its triangles, its curves and the direction from which it is seen. */
  async detail(index: number, up: Up): Promise<Contact> {
    const key = `${index}?up=${up}`;
    let contact = this.details.get(key);
    if (!contact) {
      contact = await getJson<Contact>(`contacts/${key}`);
      this.details.set(key, contact);
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

  /** How large it is, in a few words. */
  sizeText(contact: Contact, frame = worstOf(contact)): string {
    if (!frame) return touchText(this.unknownFrames, this.scene.frames === 1);
    return depthText(frame, String(this.scene.settings['unit'] ?? ''));
  }

  groupOf(contact: Contact): Group {
    return this.groups.find(({ contacts }) => contacts.includes(contact))!;
  }

  /** The contact of a group that is at a position, else the nearest one. */
  nearest({ contacts }: Group, position: number): number {
    const away = ({ first_time, last_time }: Contact) => Math.max(0, this.positionOf(first_time) - position, position - this.positionOf(last_time));
    return this.items.indexOf(contacts.reduce((best, contact) => (away(contact) < away(best) ? contact : best)));
  }

  /** The names of the two sides, where they differ. */
  sideNames({ sides }: Contact): string[] {
    const names = sides.map(({ name }) => name);
    return names[0] === names[1] ? ['First side', 'Second side'] : names;
  }

  /** The names of the two sides as one; what is within the only object is named by its place. */
  title(contact: Contact): string {
    return this.scene.objects.length === 1 && !contact.named ? `at ${placeText(contact)}` : namesText(contact);
  }
}

/** The frames in which a contact crosses, as text. */
export function framesText({ frames, first_time }: Contact): string {
  if (frames.length === 0) return `frame ${short(first_time)}`;
  const [from, to] = [short(frames[0]!.time), short(frames.at(-1)!.time)];
  return from === to ? `frame ${from}` : `frames ${from}–${to}`;
}
