// The timeline: the answers of all steps, and the current position.
import { el, icon, setText } from '../shared/dom';
import { collisionsOf, stepText, type Step } from '../shared/steps';
import type { SceneInfo } from './api';
import type { Check } from './check';
import type { Clock } from './clock';

const kPlay = 'M7 4v16l13-8z';
const kPause = 'M6 4h4v16H6zm8 0h4v16h-4z';
const kStartWidth = 9;
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
  private readonly strip = el('canvas', { className: 'strip' });
  private readonly cursor = el('div', { className: 'cursor' });
  private readonly where = el('output', { className: 'where' });
  private readonly within = el('input', { type: 'range', min: '0', max: '1', step: '0.001', value: '0', className: 'within', 'aria-label': 'Time within the step' });
  private readonly track: HTMLElement;

  constructor(
    private readonly scene: SceneInfo,
    private readonly clock: Clock,
    private readonly check: Check,
    private readonly actions: TimelineActions,
  ) {
    this.track = this.makeTrack();
    this.element = el('div', { className: 'timeline' }, this.makeButtons(), this.track);
    this.within.addEventListener('input', () => actions.seekTime(Number(this.within.value)));
    new ResizeObserver(() => this.paint()).observe(this.track);
  }

  private makeButtons(): HTMLElement {
    const button = (path: string, title: string, action: () => void, className = '') =>
      el('button', { className: `quiet ${className}`, type: 'button', title, 'aria-label': title, onclick: action }, icon(path));
    const play = el('button', { className: 'play', type: 'button', title: 'Play or pause (Space)', 'aria-label': 'Play or pause', onclick: this.actions.play }, this.playIcon);
    const speed = el('select', { title: 'Speed ([ and ])', 'aria-label': 'Speed', className: 'speed' });
    for (const value of kSpeeds) speed.append(el('option', { value: String(value), selected: value === 1 }, `${value}×`));
    speed.addEventListener('change', () => (this.clock.speed = Number(speed.value)));
    this.changeSpeed = (by) => {
      speed.selectedIndex = Math.min(Math.max(0, speed.selectedIndex + by), kSpeeds.length - 1);
      this.clock.speed = Number(speed.value);
    };
    const s = this.clock.substeps;
    return el(
      'div',
      { className: 'buttons' },
      button('M6 5h2v14H6zm3 7 9-7v14z', 'To the start (Home)', () => this.actions.seekPosition(0)),
      button('M17 5v14l-11-7z', s > 1 ? 'One substep back (←)' : 'One step back (←)', () => this.actions.move(-1)),
      play,
      button('M7 5v14l11-7z', s > 1 ? 'One substep on (→)' : 'One step on (→)', () => this.actions.move(1)),
      button('M11 5v14l-9-7zm4 4a3 3 0 1 1 0 6 3 3 0 0 1 0-6z', 'Previous step with collisions, or the start if it crosses (P)', () => this.actions.collision(-1), 'collision'),
      button('M13 5v14l9-7zm-4 4a3 3 0 1 0 0 6 3 3 0 0 0 0-6z', 'Next step with collisions (N)', () => this.actions.collision(1), 'collision'),
      speed,
      el('label', { className: 'inner', title: 'Time within the step (, and .)' }, el('span', {}, 'in step'), this.within),
      this.where,
    );
  }

  changeSpeed: (by: number) => void = () => {};

  private makeTrack(): HTMLElement {
    const track = el(
      'div',
      { className: 'track', tabIndex: 0, role: 'slider', 'aria-label': 'Timeline, in frames', 'aria-valuemin': '0', 'aria-valuemax': String(this.scene.frames - 1) },
      this.strip,
      this.cursor,
    );
    const seek = (event: PointerEvent) => {
      const box = track.getBoundingClientRect();
      this.actions.seekPosition(((event.clientX - box.left) / box.width) * (this.scene.frames - 1));
    };
    track.addEventListener('pointerdown', (event) => {
      track.setPointerCapture(event.pointerId);
      seek(event);
    });
    track.addEventListener('pointermove', (event) => {
      if (track.hasPointerCapture(event.pointerId)) seek(event);
    });
    return track;
  }

  /** The answers of all steps: hatched until checked; green up to where everything is proven free; gray where only new contacts are ruled out; red bars for numbers of collisions. Crossings in the first frame are marked at the start. */
  paint(): void {
    const { clientWidth: width, clientHeight: height } = this.track;
    if (width === 0) return;
    const ratio = Math.min(devicePixelRatio, 2);
    this.strip.width = width * ratio;
    this.strip.height = height * ratio;
    const g = this.strip.getContext('2d')!;
    g.scale(ratio, ratio);
    const style = getComputedStyle(document.documentElement);
    const color = (name: string) => style.getPropertyValue(name).trim();
    g.fillStyle = color('--stage');
    g.fillRect(0, 0, width, height);
    g.strokeStyle = color('--line');
    for (let x = -height; x < width; x += 6) {
      g.beginPath();
      g.moveTo(x, height);
      g.lineTo(x + height, 0);
      g.stroke();
    }
    const total = Math.max(1, this.scene.steps);
    const { free, steps, startsCrossing } = this.check;
    g.fillStyle = color('--calm');
    g.fillRect(0, 0, (steps.length / total) * width, height);
    g.fillStyle = color('--free');
    g.fillRect(0, 0, (free / total) * width, height);
    let maxCount = 1;
    for (const step of steps) maxCount = Math.max(maxCount, collisionsOf(step));
    if (startsCrossing) this.paintStart(g, this.clock.still ? width : kStartWidth, height, color);
    g.fillStyle = color('--bar');
    for (const step of steps) {
      const count = collisionsOf(step);
      if (count === 0) continue;
      const barHeight = Math.max(5, (Math.log1p(count) / Math.log1p(maxCount)) * (height - 3));
      const x = (step.number / total) * width;
      g.fillRect(x, height - barHeight, Math.max(2, width / total + 0.4), barHeight);
    }
  }

  private paintStart(g: CanvasRenderingContext2D, width: number, height: number, color: (name: string) => string): void {
    g.save();
    g.beginPath();
    g.rect(0, 0, width, height);
    g.clip();
    g.fillStyle = color('--cross');
    g.fillRect(0, 0, width, height);
    g.strokeStyle = color('--cross-dark');
    g.lineWidth = 2.5;
    for (let x = 0; x < width + height; x += 6.5) {
      g.beginPath();
      g.moveTo(x, 0);
      g.lineTo(x - height, height);
      g.stroke();
    }
    g.restore();
    g.fillStyle = color('--cross-dark');
    g.fillRect(width - 1.5, 0, 1.5, height);
  }

  /** Updates the cursor and the text of the position. */
  show(waiting: boolean): void {
    const { clock, scene } = this;
    const share = scene.frames > 1 ? clock.position / (scene.frames - 1) : 0;
    this.cursor.style.left = `${100 * share}%`;
    if (document.activeElement !== this.within) this.within.value = String(clock.t);
    const step = this.check.steps[clock.step];
    const from = scene.frame_numbers[clock.frame] ?? 0;
    const to = scene.frame_numbers[Math.min(clock.frame + 1, scene.frames - 1)] ?? from;
    const unchecked = { frame: from, next_frame: to, substep: clock.step % clock.substeps } as Step;
    const text = clock.still ? `frame ${from}` : `${stepText(step ?? unchecked, clock.substeps)}, ${clock.t.toFixed(3)} of the way`;
    setText(this.where, waiting ? `loading ${text}` : text);
    this.track.setAttribute('aria-valuenow', clock.position.toFixed(3));
    this.track.setAttribute('aria-valuetext', this.check.startsCrossing && clock.position === 0 ? `${text}, starts crossing` : text);
  }

  showPlaying(playing: boolean): void {
    this.playIcon.firstElementChild!.setAttribute('d', playing ? kPause : kPlay);
  }
}
