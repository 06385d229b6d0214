// What is painted, and the settings of the brush, in the form of the repair.
import { css, kYellow } from '../shared/colors';
import { counted } from '../shared/format';
import { el, setText } from '../shared/dom';
import { kBrushPixels, type Painting } from './painting';

export function paintTools(painting: Painting): HTMLElement {
  const button = (text: string, action: () => void) => el('button', { className: 'small', type: 'button', onclick: action }, text);
  const paint = button('Paint what stays', () => painting.change({ active: !painting.active }));
  const erase = button('Erase', () => painting.change({ erases: !painting.erases }));
  const clear = button('Clear', () => painting.clear());
  const size = el('input', { type: 'range', min: String(kBrushPixels.least), max: String(kBrushPixels.most), value: String(painting.radius), 'aria-label': 'Size of the brush' });
  size.addEventListener('input', () => painting.change({ radius: Number(size.value) }));
  const count = el('span', { className: 'note' });
  const swatch = el('span', { className: 'swatch', style: { background: css(kYellow) } });
  const tools = el('div', { className: 'row' }, el('label', {}, 'Size ', size), erase);
  const help = el('p', { className: 'note' }, 'Drag over a surface to paint, beside it to orbit. Shift or Alt erases, Esc ends.');
  const show = () => {
    const { active, erases } = painting;
    paint.setAttribute('aria-pressed', String(active));
    erase.setAttribute('aria-pressed', String(erases));
    tools.hidden = help.hidden = !active;
    clear.hidden = swatch.hidden = count.hidden = painting.count === 0;
    setText(count, `${counted(painting.count, 'vertex', 'vertices')} ${painting.count === 1 ? 'stays' : 'stay'}`);
  };
  painting.onChange(show);
  show();
  return el('div', { className: 'paint', role: 'group', 'aria-label': 'Painted vertices' }, el('div', { className: 'row' }, paint, clear, swatch, count), tools, help);
}
