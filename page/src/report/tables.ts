// Sections and tables of reports.
import { append, el } from '../shared/dom';

const numberCell = (text: string): HTMLElement => el('td', { className: 'number' }, text);

export function table(heads: string[], rows: (string | HTMLElement)[][], numbers: boolean[]): HTMLElement {
  const cell = (value: string | HTMLElement, k: number) => (numbers[k] && typeof value === 'string' ? numberCell(value) : el('td', {}, value));
  return el(
    'div',
    { className: 'wide' },
    el(
      'table',
      {},
      append_(el('thead', {}), [append_(el('tr', {}), heads.map((head, k) => el('th', { className: numbers[k] ? 'number' : '' }, head)))]),
      append_(el('tbody', {}), rows.map((row) => append_(el('tr', {}), row.map(cell)))),
    ),
  );
}

function append_<T extends HTMLElement>(parent: T, children: HTMLElement[]): T {
  append(parent, ...children);
  return parent;
}

export function section(title: string, ...content: (HTMLElement | null)[]): HTMLElement {
  return el('section', {}, el('h2', {}, title), ...content);
}
