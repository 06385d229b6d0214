// How it is looked at: which axis is up, what the camera follows, and a plane that cuts.
import { el } from '../shared/dom';
import type { Up } from '../shared/upright';

export interface ViewState {
  up: Up;
  follow: boolean;
  ground: boolean;
  cut: '' | 'x' | 'y' | 'z';
  cutAt: number; // from 0 to 1 through the bounds of the motion
  cutTurned: boolean; // cut away the other half
}

export class ViewOptions {
  readonly element: HTMLElement;
  readonly state: ViewState;
  /** Whether the user has chosen the upright axis. */
  turned = false;
  private readonly ups = new Map<Up, HTMLInputElement>();

  constructor(guess: Up, private readonly changed: (upTurned: boolean) => void) {
    this.state = { up: guess, follow: false, ground: true, cut: '', cutAt: 0.5, cutTurned: false };
    this.element = el('div', {}, this.camera(guess), this.cut());
  }

  private camera(guess: Up): HTMLElement {
    const box = el('fieldset', { className: 'options' }, el('legend', {}, 'View'));
    const ups = el('div', { className: 'choice', role: 'radiogroup', 'aria-label': 'Upright axis' }, 'Upright axis');
    for (const up of ['y', 'z'] as const) {
      const input = el('input', { type: 'radio', name: 'up', value: up, checked: up === guess });
      input.addEventListener('change', () => this.turn(up));
      this.ups.set(up, input);
      ups.append(el('label', {}, input, up));
    }
    box.append(ups, this.check('follow', 'Follow the mesh', 'the camera moves along'), this.check('ground', 'Ground', 'a grid at the lowest point of all frames'));
    return box;
  }

  private check(name: 'follow' | 'ground', title: string, help: string): HTMLElement {
    const input = el('input', { type: 'checkbox', checked: this.state[name], 'data-option': name });
    input.addEventListener('change', () => {
      this.state[name] = input.checked;
      this.changed(false);
    });
    return el('label', { className: 'line' }, input, el('span', {}, title, el('small', {}, help)));
  }

  private cut(): HTMLElement {
    const { state } = this;
    const axis = el('select', { 'aria-label': 'Axis of the cut', 'data-option': 'cut' }, el('option', { value: '' }, 'no cut'), ...['x', 'y', 'z'].map((name) => el('option', { value: name }, `across ${name}`)));
    const at = el('input', { type: 'range', min: '0', max: '1', step: '0.002', value: '0.5', disabled: true, 'aria-label': 'Place of the cut' });
    const turn = el('button', { className: 'small', type: 'button', disabled: true, title: 'Cut away the other half' }, 'Turn');
    axis.addEventListener('change', () => {
      state.cut = axis.value as ViewState['cut'];
      at.disabled = turn.disabled = state.cut === '';
      this.changed(false);
    });
    at.addEventListener('input', () => {
      state.cutAt = Number(at.value);
      this.changed(false);
    });
    turn.addEventListener('click', () => {
      state.cutTurned = !state.cutTurned;
      this.changed(false);
    });
    return el('fieldset', { className: 'options' }, el('legend', {}, 'Cut'), el('div', { className: 'choice' }, axis, at, turn));
  }

  turn(up: Up): void {
    this.turned = true;
    this.setUp(up);
  }

  setUp(up: Up): void {
    this.ups.get(up)!.checked = true;
    this.state.up = up;
    this.changed(true);
  }
}
