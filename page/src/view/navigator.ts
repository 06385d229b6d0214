// Where the user is: the time, and the contact or pair that is chosen.
import { collisionsOf } from '../shared/steps';
import type { Pair } from './api';
import type { Check } from './check';
import { kStart } from './check';
import type { Clock } from './clock';
import type { CollisionPanel } from './collisions';
import type { ContactPanel } from './contactpanel';
import type { Contacts } from './contacts';
import type { Content } from './content';
import type { Layout } from './layout';
import { clearDirection } from './sight';
import type { Stage } from './stage';
import type { Timeline } from './timeline';
import type { Track } from './track';

export interface Parts {
  clock: Clock;
  check: Check;
  contacts: Contacts;
  collisions: CollisionPanel;
  cards: ContactPanel;
  layout: Layout;
  stage: Stage;
  timeline: Timeline;
  track: Track;
}

export class Navigator {
  content: Content | null = null; // null before the triangles are loaded
  /** The user has gone somewhere, so the page goes nowhere by itself. */
  touched = false;
  chosen: { step: number; pair: Pair } | null = null;
  contact: number | null = null; // the chosen one, an index of the list
  onDeselect: () => void = () => {};
  private arrival: (() => void) | null = null; // to do when the frame is shown

  constructor(
    private readonly parts: Parts,
    private readonly changed: () => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  play(playing: boolean): void {
    const { clock, timeline } = this.parts;
    if (playing && clock.frames === 1) return;
    if (playing) {
      this.touched = true;
      this.showMotion();
    }
    if (playing && clock.atEnd) clock.seek(0);
    clock.playing = playing;
    timeline.showPlaying(playing);
    this.changed();
  }

  /** Moves in time. */
  goTo(move: () => void, playOn = false): void {
    if (!playOn) this.play(false);
    this.touched = true;
    this.showMotion();
    move();
    this.changed();
  }

  /** Using the timeline shows the motion instead of a shape of the model. */
  private showMotion(): void {
    const { layout } = this.parts;
    if (layout.openTab === 'shapes') layout.open('contacts');
  }

  showAll(): void {
    this.deselect();
    this.parts.stage.camera.showAll();
  }

  deselect(): void {
    this.chosen = null;
    this.arrival = null;
    this.content?.lines.clear();
    this.setContact(null);
    this.onDeselect();
    this.changed();
  }

  private setContact(index: number | null): void {
    this.contact = index;
    this.parts.track.choose(index);
    if (index === null) this.content?.contact.set(null);
  }

  /** Chooses the next or previous one of the list that is open. */
  moveInList(by: number): void {
    const { collisions, contacts, layout } = this.parts;
    if (layout.openTab !== 'contacts') return collisions.move(by);
    const count = contacts.items.length;
    if (count > 0) void this.chooseContact(Math.min(Math.max(0, (this.contact ?? -1) + by), count - 1));
  }

  nextCollision(direction: 1 | -1): void {
    const { check, clock } = this.parts;
    const step = check.nextColliding(clock.step, clock.t, direction);
    if (step === kStart) this.goTo(() => clock.seek(0));
    else if (step !== null) this.goTo(() => clock.seek(step, check.steps[step]!.toi));
  }

  goToFirst(): void {
    const { check, clock, contacts } = this.parts;
    if (contacts.items.length > 0) return void this.chooseContact(contacts.first, true, contacts.positionOf(contacts.items[contacts.first]!.first_time));
    if (check.startsCrossing) return this.goTo(() => clock.seek(0));
    const step = check.steps.find((one) => collisionsOf(one) > 0);
    if (step) this.goTo(() => clock.seek(step.number, step.toi));
  }

  choose(pair: Pair): void {
    const { content } = this;
    const { clock, stage } = this.parts;
    if (!content) return;
    this.deselect();
    this.chosen = { step: clock.step, pair };
    this.goTo(() => clock.seek(clock.step, pair.toi));
    this.arrival = () => {
      content.lines.show(content.surfaces, pair);
      const point = content.relative(pair.point);
      const size = content.sizeOf(pair);
      const { camera, scale } = stage;
      camera.approach(point.clone().multiplyScalar(scale), 5 * size * scale, clearDirection(content.surfaces, point, 2 * size, camera.direction, camera.up));
    };
  }

  /** A pair chosen in another step is deselected, and so is a contact that is not in this pose. */
  leave(step: number): void {
    if (this.chosen && this.chosen.step !== step) {
      this.chosen = null;
      this.content?.lines.clear();
    }
    const { clock, contacts } = this.parts;
    if (clock.still && this.contact !== null && !contacts.at(step).some(({ index }) => index === this.contact)) this.setContact(null);
  }

  /** The position at which a contact of the list is worst, or first touches. */
  worstPosition(index: number): number {
    const { contacts } = this.parts;
    const contact = contacts.items[index]!;
    return contacts.positionOf(contact.worst ?? contact.first_time);
  }

  /** Goes to a contact of the list, at `position` or else in its worst frame; with `fly` the camera goes there, too. */
  async chooseContact(index: number, fly = true, position?: number): Promise<void> {
    const { content } = this;
    const { cards, clock, contacts, stage } = this.parts;
    if (!content || !contacts.items[index]) return;
    this.deselect();
    this.setContact(index);
    cards.reveal(index);
    this.goTo(() => clock.seekPosition(position ?? this.worstPosition(index)));
    try {
      const contact = await contacts.detail(index, stage.camera.axis);
      if (this.contact !== index) return; // Another was chosen meanwhile.
      content.contact.set(contact);
    } catch (error) {
      return this.failed(error);
    }
    if (fly) this.arrival = () => stage.camera.approach(content.contact.place, 1.55 * content.contact.radius, content.contact.direction() ?? stage.camera.direction);
    this.changed();
  }

  /** The frame is shown: flies to what was chosen in it. */
  arrive(): void {
    const { arrival } = this;
    this.arrival = null;
    arrival?.();
  }
}
