// A click on the surface shows what is known about the triangle under it.
import * as THREE from 'three';
import { kReasons } from '../shared/colors';
import { el } from '../shared/dom';
import { capital, isStatic, wordsOf, type Words } from '../shared/words';
import type { SceneInfo } from './api';
import { copyButton } from './copy';
import type { Stage } from './stage';
import { firstHit, type Surface } from './surface';

const kStillPixels = 4; // A press that moves farther is a drag.

export class Inspector {
  private chosen: { object: number; face: number } | null = null;
  private shown = '';
  private readonly words: Words;
  private changed = false;

  constructor(
    private readonly stage: Stage,
    private readonly surfaces: Surface[],
    private readonly scene: SceneInfo,
    private readonly card: HTMLElement,
    private readonly approach: (point: THREE.Vector3, size: number) => void,
  ) {
    this.words = wordsOf(isStatic(scene.settings));
    let press = [0, 0];
    const { canvas } = stage;
    canvas.addEventListener('pointerdown', (event) => (press = [event.clientX, event.clientY]));
    canvas.addEventListener('click', (event) => {
      if (Math.hypot(event.clientX - press[0]!, event.clientY - press[1]!) > kStillPixels) return;
      const hit = this.pick(event);
      this.chosen = hit ? { object: hit.object, face: hit.face } : null;
      this.changed = true;
      this.render(this.faces, this.step);
    });
    canvas.addEventListener('dblclick', (event) => {
      const hit = this.pick(event);
      if (hit) this.approach(hit.point, 0.06 / stage.scale);
    });
  }

  private faces: Uint8Array[] | null = null;
  private step = -1;

  /** Takes the card away. */
  close(): void {
    this.chosen = null;
    this.render(null, -1);
  }

  private pick(event: MouseEvent): ReturnType<typeof firstHit> {
    return firstHit(this.surfaces, this.stage.ray(event.clientX, event.clientY));
  }

  /** Shows the data of the current step's triangles. */
  show(faces: Uint8Array[] | null, step: number): void {
    this.faces = faces;
    this.step = step;
    this.render(faces, step);
  }

  private render(faces: Uint8Array[] | null, step: number): void {
    this.card.hidden = this.chosen === null;
    if (!this.chosen) return;
    const { object, face } = this.chosen;
    const key = `${object}/${face}/${step}/${faces !== null}`;
    if (key === this.shown && !this.changed) return;
    this.shown = key;
    this.changed = false;
    const info = this.scene.objects[object]!;
    const corners = Array.from(this.surfaces[object]!.triangles.subarray(3 * face, 3 * face + 3)).join(', ');
    this.card.replaceChildren(
      el('button', { className: 'quiet close', type: 'button', title: 'Close (Escape)', 'aria-label': 'Close', onclick: () => this.close() }, '×'),
      el('strong', {}, `Triangle ${face}${this.scene.objects.length > 1 ? ` of ${info.name}` : ''}`),
      el('span', {}, `vertices ${corners} `, copyButton(`triangle ${face}, vertices ${corners}`)),
      el('span', {}, faces ? this.proof(faces[object]!, face, info.triangles) : `Choose a proof color or a ${this.words.step} with ${this.words.collisions} to see what is known of it`),
    );
  }

  private proof(data: Uint8Array, face: number, n: number): string {
    const reason = kReasons[this.scene.reasons[data[n + face]!] ?? ''];
    const level = (data[2 * n + face]! << 24) >> 24;
    const { step, collisions } = this.words;
    const marks = data[face]!;
    const does = [marks & 6 && 'is inside or crosses', marks & 1 && 'meets another'].filter(Boolean).join(' and ');
    const parts = [`${does ? capital(does) : `No ${collisions}`} in this ${step}.`, `${reason?.title ?? 'Unknown'}${level >= 0 ? `, level ${level}` : ''}`];
    if (level >= 0) parts.push(`margin ${(data[3 * n + face]! / 255).toFixed(2)}`);
    return `${parts[0]} ${parts.slice(1).join(', ')}.`;
  }
}
