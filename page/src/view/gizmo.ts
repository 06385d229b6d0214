// Three axes in a corner of the picture: how the camera stands. A click on an end looks from there.
import * as THREE from 'three';
import { el } from '../shared/dom';
import type { Side } from './camera';

const kSvg = 'http://www.w3.org/2000/svg';
const kSize = 74;
const kRadius = 27;
const kColors = ['#d8412f', '#3f9142', '#3b78d8'];
const kNames = ['x', 'y', 'z'];

interface End {
  axis: number;
  sign: 1 | -1;
  line: SVGLineElement | null;
  dot: SVGCircleElement;
  label: SVGTextElement | null;
  group: SVGGElement;
}

function svg<K extends keyof SVGElementTagNameMap>(tag: K, attributes: Record<string, string>): SVGElementTagNameMap[K] {
  const element = document.createElementNS(kSvg, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

export class Gizmo {
  readonly element = el('div', { className: 'gizmo', title: 'Axes: a click on an end looks from there' });
  private readonly picture = svg('svg', { viewBox: `${-kSize / 2} ${-kSize / 2} ${kSize} ${kSize}`, width: String(kSize), height: String(kSize), 'aria-label': 'Axes' });
  private readonly ends: End[] = [];
  private shown = '';

  constructor(private readonly look: (side: Side) => void, private readonly up: () => THREE.Vector3) {
    for (const axis of [0, 1, 2]) {
      for (const sign of [1, -1] as const) this.ends.push(this.makeEnd(axis, sign));
    }
    this.element.append(this.picture);
  }

  private makeEnd(axis: number, sign: 1 | -1): End {
    const color = kColors[axis]!;
    const group = svg('g', { class: 'end' });
    const line = sign > 0 ? svg('line', { x1: '0', y1: '0', stroke: color, 'stroke-width': '2.5' }) : null;
    const dot = svg('circle', { r: sign > 0 ? '8' : '5.5', fill: sign > 0 ? color : 'var(--panel)', stroke: color, 'stroke-width': '1.5' });
    const label = sign > 0 ? svg('text', { 'text-anchor': 'middle', 'dominant-baseline': 'central', fill: '#fff', 'font-size': '11', 'font-weight': '700' }) : null;
    if (label) label.textContent = kNames[axis]!;
    group.append(...[line, dot, label].filter((one) => one !== null));
    group.addEventListener('click', () => this.look(this.sideOf(axis, sign)));
    return { axis, sign, line, dot, label, group };
  }

  private sideOf(axis: number, sign: 1 | -1): Side {
    if (axis === 0) return sign > 0 ? 'right' : 'left';
    const upright = this.up().y > 0 ? 1 : 2;
    if (axis === upright) return sign > 0 ? 'top' : 'bottom';
    // With y up, the front is seen from +z; with z up, from -y.
    return sign > 0 === (upright === 1) ? 'front' : 'back';
  }

  /** Turns as the camera does. */
  show(camera: THREE.Camera): void {
    const turn = camera.matrixWorldInverse;
    const key = turn.elements.slice(0, 11).map((value) => value.toFixed(3)).join();
    if (key === this.shown) return;
    this.shown = key;
    const depth = new Map<End, number>();
    for (const end of this.ends) {
      const at = new THREE.Vector3().setComponent(end.axis, end.sign).transformDirection(turn);
      const [x, y] = [(kRadius * at.x).toFixed(1), (-kRadius * at.y).toFixed(1)];
      depth.set(end, at.z);
      end.line?.setAttribute('x2', x);
      end.line?.setAttribute('y2', y);
      end.dot.setAttribute('cx', x);
      end.dot.setAttribute('cy', y);
      end.label?.setAttribute('x', x);
      end.label?.setAttribute('y', y);
    }
    this.picture.replaceChildren(...[...this.ends].sort((a, b) => depth.get(a)! - depth.get(b)!).map(({ group }) => group));
  }
}
