// The timeline: buttons, the position, and the track.
import { el, icon, setText } from '../shared/dom';
import { stepText, type Step } from '../shared/steps';
import { wordsOf } from '../shared/words';
import type { SceneInfo } from './api';
import type { Check } from './check';
import type { Clock } from './clock';
import type { HoverCard } from './hovercard';
import type { Track } from './track';

const kPlay = 'M7 4v16l13-8z';
const kPause = 'M6 4h4v16H6zm8 0h4v16h-4z';
const kSpeeds = [0.1, 0.25, 0.5, 1, 2, 4];

export interface TimelineActions {
  play: () => void;
  move: (steps: number) => void;
  seekPosition: (position: number) => void;
  seekTime: (t: number) => void;
  collision: (direction: 1 | -1) => void;
}

export class Timeline {
  readonly element: HTMLElement;
  private readonly playIcon = icon(kPlay);
  private readonly number = el('input', { type: 'number', className: 'number', step: '1', 'aria-label': 'Frame', title: 'Type a frame (G)' });
  private readonly where = el('output', { className: 'where' });
  private readonly within = el('input', { type: 'range', min: '0', max: '1', step: '0.001', value: '0', className: 'within', 'aria-label': 'Time within the step' });

  constructor(
    private readonly scene: SceneInfo,
    private readonly clock: Clock,
    private readonly check: Check,
    private readonly track: Track,
    card: HoverCard,
    private readonly actions: TimelineActions,
  ) {
    this.element = el('div', { className: 'timeline' }, this.makeButtons(), track.element, card.element);
    this.within.addEventListener('input', () => actions.seekTime(Number(this.within.value)));
    this.number.addEventListener('change', () => this.goToTyped());
  }

  /** Goes to the frame that was typed, or the last one before it. */
  private goToTyped(): void {
    const typed = this.number.valueAsNumber;
    const numbers = this.scene.frame_numbers;
    if (Number.isFinite(typed)) this.actions.seekPosition(Math.max(0, numbers.filter((number) => number <= typed).length - 1));
    this.number.blur();
  }

  typeFrame(): void {
    this.number.focus();
    this.number.select();
  }

  paint(): void {
    this.track.paint();
  }

  private makeButtons(): HTMLElement {
    const button = (path: string, title: string, action: () => void, className = '') =>
      el('button', { className: `quiet ${className}`, type: 'button', title, 'aria-label': title, onclick: action }, icon(path));
    const play = el('button', { className: 'play', type: 'button', title: 'Play or pause (Space)', 'aria-label': 'Play or pause', onclick: this.actions.play }, this.playIcon);
    const speed = el('select', { title: 'Speed ([ and ])', 'aria-label': 'Speed', className: 'speed' });
    for (const value of kSpeeds) speed.append(el('option', { value: String(value), selected: value === this.clock.speed }, `${value}×`));
    speed.addEventListener('change', () => (this.clock.speed = Number(speed.value)));
    this.changeSpeed = (by) => {
      speed.selectedIndex = Math.min(Math.max(0, speed.selectedIndex + by), kSpeeds.length - 1);
      this.clock.speed = Number(speed.value);
    };
    const { step, collisions, orStart } = wordsOf(this.check.poses);
    const one = this.clock.substeps > 1 ? 'substep' : step;
    return el(
      'div',
      { className: 'buttons' },
      button('M6 5h2v14H6zm3 7 9-7v14z', 'To the start (Home)', () => this.actions.seekPosition(0)),
      button('M17 5v14l-11-7z', `One ${one} back (←)`, () => this.actions.move(-1)),
      play,
      button('M7 5v14l11-7z', `One ${one} on (→)`, () => this.actions.move(1)),
      button('M11 5v14l-9-7zm4 4a3 3 0 1 1 0 6 3 3 0 0 1 0-6z', `Previous ${step} with ${collisions}${orStart} (P)`, () => this.actions.collision(-1), 'collision'),
      button('M13 5v14l9-7zm-4 4a3 3 0 1 0 0 6 3 3 0 0 0 0-6z', `Next ${step} with ${collisions} (N)`, () => this.actions.collision(1), 'collision'),
      speed,
      !this.clock.still && el('label', { className: 'inner', title: 'Time within the step (, and .)' }, el('span', {}, 'in step'), this.within),
      el('label', { className: 'go' }, 'frame ', this.number),
      this.where,
    );
  }

  changeSpeed: (by: number) => void = () => {};

  /** Updates the cursor and the text of the position. */
  show(waiting: boolean): void {
    const { clock, scene } = this;
    this.track.showCursor();
    if (document.activeElement !== this.within) this.within.value = String(clock.t);
    const step = this.check.steps[clock.step];
    const from = scene.frame_numbers[clock.frame] ?? 0;
    const to = scene.frame_numbers[Math.min(clock.frame + 1, scene.frames - 1)] ?? from;
    const unchecked = { frame: from, next_frame: to, substep: clock.step % clock.substeps } as Step;
    const name = scene.frame_names[clock.frame];
    const text = name && clock.blend === 0 ? name : clock.still ? `frame ${from}` : `${stepText(step ?? unchecked, clock.substeps)}, ${clock.t.toFixed(3)} of the way`;
    setText(this.where, waiting ? `loading ${text}` : text);
    if (document.activeElement !== this.number) this.number.value = String(from + Math.round((to - from) * clock.blend * 100) / 100);
    this.track.element.setAttribute('aria-valuenow', clock.position.toFixed(3));
    this.track.element.setAttribute('aria-valuetext', this.check.startsCrossing && clock.position === 0 ? `${text}, starts crossing` : text);
  }

  showPlaying(playing: boolean): void {
    this.playIcon.firstElementChild!.setAttribute('d', playing ? kPause : kPlay);
  }
}
