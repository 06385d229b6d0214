// Elements without markup: strings from files enter the page as text.

type Child = Node | string | null | undefined | false;
type Properties = Record<string, unknown>;

/** An element with properties (`class`, `data-*` and `aria-*` as attributes, `on...` as listeners) and children. */
export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Properties = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (name.startsWith('on')) {
      element.addEventListener(name.slice(2), value as EventListener);
    } else if (name === 'style') {
      for (const [key, text] of Object.entries(value as Record<string, string>)) element.style.setProperty(key, text);
    } else if (name in element && name !== 'list') {
      (element as unknown as Properties)[name] = value;
    } else {
      element.setAttribute(name === 'className' ? 'class' : name, String(value));
    }
  }
  append(element, ...children);
  return element;
}

/** What the readers of objects left out or assumed. */
export const notesOfReaders = (objects: { name: string; notes?: string[] }[]): HTMLElement[] =>
  objects.flatMap(({ name, notes = [] }) => notes.map((note) => el('p', { className: 'note' }, `${name}: ${note}`)));

export function append(parent: Element, ...children: Child[]): void {
  for (const child of children) if (child) parent.append(child);
}

/** Sets the text only when it differs, to avoid needless layout. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

const kSvg = 'http://www.w3.org/2000/svg';

/** A 24 x 24 icon from one path, drawn in the color of the text. */
export function icon(path: string): SVGSVGElement {
  const svg = document.createElementNS(kSvg, 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  svg.setAttribute('class', 'icon');
  const shape = document.createElementNS(kSvg, 'path');
  shape.setAttribute('d', path);
  svg.append(shape);
  return svg;
}
