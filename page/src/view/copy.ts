// Buttons that copy ids.
import { el } from '../shared/dom';

const kSaidMs = 1200;

export function copyButton(text: string): HTMLElement {
  const button = el('button', { className: 'copy', type: 'button', title: `Copy "${text}"`, 'aria-label': `Copy ${text}` }, 'copy');
  button.addEventListener('click', async (event) => {
    event.stopPropagation();
    try {
      await navigator.clipboard.writeText(text);
      button.textContent = 'copied';
    } catch {
      button.textContent = 'not allowed';
    }
    setTimeout(() => (button.textContent = 'copy'), kSaidMs);
  });
  return button;
}
