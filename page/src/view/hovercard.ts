// A card over the timeline: the frame under the pointer, its contacts, and a small picture.
import { el } from '../shared/dom';
import { namesText, type Contact } from '../shared/contact';
import { counted } from '../shared/format';
import { collisionsOf } from '../shared/steps';
import { wordsOf } from '../shared/words';
import type { SceneInfo } from './api';
import type { Check } from './check';
import type { Contacts } from './contacts';

const kWidth = 168;
const kHeight = 112;
const kMaxLines = 4;
const kRestMs = 60; // A picture is drawn when the pointer rests.

export class HoverCard {
  readonly element = el('div', { className: 'hovercard', hidden: true });
  private readonly picture = el('canvas', { width: kWidth, height: kHeight });
  private readonly text = el('div', { className: 'lines' });
  private timer = 0;

  constructor(
    private readonly scene: SceneInfo,
    private readonly check: Check,
    private readonly contacts: Contacts,
    private readonly draw: (position: number, width: number, height: number) => ImageData | null, // null: not loaded
  ) {
    this.element.append(this.picture, this.text);
  }

  show(position: number, x: number, width: number, lane: number | null): void {
    const frame = Math.round(position);
    this.text.replaceChildren(el('strong', {}, this.scene.frame_names[frame] ?? `frame ${this.scene.frame_numbers[frame] ?? frame}`), ...this.lines(frame, lane));
    this.element.hidden = false;
    this.element.style.left = `${Math.min(Math.max(0, x - kWidth / 2), Math.max(0, width - kWidth - 16))}px`;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => {
      const image = this.draw(frame, kWidth, kHeight);
      this.picture.hidden = image === null;
      if (image) this.picture.getContext('2d')!.putImageData(image, 0, 0);
    }, kRestMs);
  }

  private lines(frame: number, lane: number | null): HTMLElement[] {
    const found = this.contacts.at(frame);
    if (found.length === 0) {
      const { poses, steps } = this.check;
      const substeps = poses ? 1 : this.scene.substeps;
      // No step begins in the last frame; it shows those that end there.
      const begin = Math.min(frame * substeps, Math.max(0, this.scene.steps - substeps));
      const parts = Array.from({ length: Math.min(substeps, this.scene.steps - begin) }, (_, k) => steps[begin + k]);
      const pairs = parts.reduce((sum, step) => sum + (step ? collisionsOf(step) : 0), 0);
      const none = poses ? 'nothing crosses' : 'no contact';
      const all = parts.every((step) => step !== undefined);
      return [el('span', {}, pairs > 0 ? counted(pairs, `${wordsOf(poses).colliding} pair`) : all ? none : 'not checked')];
    }
    const ofLane = ({ contact }: { contact: Contact }) => contact.group === lane;
    const listed = [...found.filter(ofLane), ...found.filter((each) => !ofLane(each))].slice(0, kMaxLines);
    const lines = listed.map(({ contact, frame }) => el('span', {}, `${contact.named ? namesText(contact) : `#${contact.number}`}: ${this.contacts.sizeText(contact, frame ?? undefined)}`));
    if (found.length > kMaxLines) lines.push(el('span', {}, `and ${found.length - kMaxLines} more`));
    return lines;
  }

  hide(): void {
    clearTimeout(this.timer);
    this.element.hidden = true;
  }
}
