// The repaired motion in the picture, and what remains in it.
import * as THREE from 'three';
import type { Contact } from '../shared/contact';
import { setText } from '../shared/dom';
import type { Data } from './data';
import type { LayerPanel } from './layers';
import type { Navigator, Parts } from './navigator';
import { kindShown, type RepairPanel } from './repair';

export class Repaired {
  constructor(
    private readonly panel: RepairPanel,
    private readonly layers: LayerPanel,
    private readonly data: Data,
    private readonly navigator: Navigator,
    private readonly parts: Parts,
    private readonly redraw: () => void,
  ) {}

  /** It is shown in place of the motion. */
  get shown(): boolean {
    return this.layers.state.source === 'repaired';
  }

  show(after: boolean): void {
    if (after && !this.panel.repaired) return;
    this.layers.setSource(after ? 'repaired' : 'motion');
  }

  /** There is another one, or there is none any more. */
  changed(): void {
    const { repaired, version, corrections } = this.panel;
    this.data.setRepaired(repaired);
    this.navigator.content?.setRepair(version);
    this.layers.offerRepaired(repaired);
    this.parts.track.setCorrections(corrections);
    this.redraw();
  }

  /** Whose sides are colored: those of the chosen contact, or what remains at this time. */
  marked(chosen: Contact | null): Contact[] {
    const { clock, contacts } = this.parts;
    if (!this.shown) return chosen ? [chosen] : [];
    const at = (time: number) => contacts.positionOf(time);
    return this.panel.remaining.filter(({ first_time, last_time }) => at(first_time) - 0.5 <= clock.position && clock.position <= at(last_time) + 0.5);
  }

  /** Looks at a contact that remains. */
  goTo(contact: Contact): void {
    const { navigator } = this;
    const { clock, contacts, stage } = this.parts;
    const { content } = navigator;
    if (!content) return;
    navigator.deselect();
    this.show(true);
    navigator.goTo(() => clock.seekPosition(contacts.positionOf(contact.worst ?? contact.first_time)));
    const [low, high] = contact.box.map((point) => content.relative(point).multiplyScalar(stage.scale)) as [THREE.Vector3, THREE.Vector3];
    stage.camera.approach(low.clone().add(high).multiplyScalar(0.5), 1.55 * Math.max(low.distanceTo(high) / 2, 1e-3));
  }

  /** Says over the picture what is shown. */
  say(badge: HTMLElement): void {
    this.panel.showSide(this.shown);
    badge.hidden = !this.shown;
    if (!this.shown) return;
    const { verdict } = this.panel;
    setText(badge, `Repaired. ${verdict?.text ?? ''}`);
    badge.dataset['kind'] = verdict ? kindShown(verdict) : '';
  }
}
