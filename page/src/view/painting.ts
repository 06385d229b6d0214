// Vertices that stay as they are in a repair, painted on the surfaces.
import { el } from '../shared/dom';
import type { SceneInfo } from './api';
import type { Stage } from './stage';
import { firstHit, type Surface } from './surface';

export const kBrushPixels = { least: 6, most: 80, first: 24 }; // of its radius

/** What is painted, and how the brush paints. */
export class Painting {
  /** Per object and vertex, 1 where it stays. */
  readonly masks: Uint8Array[];
  count = 0;
  active = false; // a drag over a surface paints
  shown = false;
  erases = false;
  radius = kBrushPixels.first;
  private readonly listeners: (() => void)[] = [];

  constructor(scene: SceneInfo) {
    this.masks = scene.objects.map(({ vertices }) => new Uint8Array(vertices));
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  change(values: Partial<Pick<Painting, 'active' | 'shown' | 'erases' | 'radius'>> = {}): void {
    Object.assign(this, values);
    for (const listener of this.listeners) listener();
  }

  set(object: number, vertex: number, painted: boolean): void {
    const mask = this.masks[object]!;
    const value = painted ? 1 : 0;
    this.count += value - mask[vertex]!;
    mask[vertex] = value;
  }

  clear(): void {
    for (const mask of this.masks) mask.fill(0);
    this.count = 0;
    this.change();
  }

  /** As the program takes them: "0:5-9,12;1:3". */
  text(): string {
    return this.masks.flatMap((mask, object) => (mask.includes(1) ? [`${object}:${rangesOf(mask).join()}`] : [])).join(';');
  }
}

function rangesOf(mask: Uint8Array): string[] {
  const ranges: string[] = [];
  for (let first = mask.indexOf(1); first >= 0; ) {
    const end = mask.indexOf(0, first);
    const last = (end < 0 ? mask.length : end) - 1;
    ranges.push(first === last ? String(first) : `${first}-${last}`);
    first = end < 0 ? -1 : mask.indexOf(1, end);
  }
  return ranges;
}

/** Paints all vertices of the surface under the pointer that are within a ball around that point, and the nearest one. */
export class Brush {
  private readonly ring = el('div', { className: 'brush', hidden: true });
  private readonly vertices: Uint32Array[]; // per object, those of triangles
  private stroke: { pointer: number; x: number; y: number } | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly surfaces: Surface[],
    private readonly painting: Painting,
  ) {
    this.vertices = surfaces.map(({ triangles }) => new Uint32Array(new Set(triangles)));
    const { parent, canvas } = stage;
    parent.append(this.ring);
    // Before the listeners of the canvas, which orbit and pick.
    const listen = <K extends 'pointerdown' | 'pointermove' | 'pointerup' | 'pointercancel' | 'click' | 'dblclick'>(type: K, action: (event: HTMLElementEventMap[K]) => boolean) =>
      parent.addEventListener(
        type,
        (event) => {
          if (painting.active && event.target === canvas && action(event)) event.stopPropagation();
        },
        { capture: true },
      );
    listen('pointerdown', (event) => this.begin(event as PointerEvent));
    listen('pointermove', (event) => this.move(event as PointerEvent));
    for (const type of ['pointerup', 'pointercancel'] as const) listen(type, (event) => this.end(event as PointerEvent));
    for (const type of ['click', 'dblclick'] as const) listen(type, () => true);
    canvas.addEventListener('pointerleave', () => (this.ring.hidden = true));
    painting.onChange(() => this.show());
    this.show();
  }

  private show(): void {
    const { painting, stage } = this;
    stage.parent.classList.toggle('painting', painting.active);
    if (!painting.active) this.ring.hidden = true;
    if (!painting.active) this.stroke = null;
    this.surfaces.forEach((surface, i) => surface.setPainted(painting.shown ? painting.masks[i]! : null));
    stage.redraw();
  }

  /** A drag that begins beside the surfaces orbits. */
  private begin(event: PointerEvent): boolean {
    if (event.button !== 0 || this.stroke) return this.stroke !== null;
    if (!this.dab(event.clientX, event.clientY, event)) return false;
    this.stroke = { pointer: event.pointerId, x: event.clientX, y: event.clientY };
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.painting.change();
    return true;
  }

  private move(event: PointerEvent): boolean {
    const { stroke, painting } = this;
    this.showRing(event);
    if (event.pointerId !== stroke?.pointer) return false;
    const [dx, dy] = [event.clientX - stroke.x, event.clientY - stroke.y];
    const parts = Math.min(20, Math.ceil(Math.hypot(dx, dy) / (painting.radius / 2)));
    for (let k = 1; k <= parts; ++k) this.dab(stroke.x + (k / parts) * dx, stroke.y + (k / parts) * dy, event);
    [stroke.x, stroke.y] = [event.clientX, event.clientY];
    painting.change();
    return true;
  }

  private end(event: PointerEvent): boolean {
    if (event.pointerId !== this.stroke?.pointer) return false;
    this.stroke = null;
    return true;
  }

  private showRing({ clientX, clientY }: PointerEvent): void {
    const box = this.stage.parent.getBoundingClientRect();
    const { radius } = this.painting;
    this.ring.hidden = false;
    for (const [name, value] of Object.entries({ left: clientX - box.left - radius, top: clientY - box.top - radius, width: 2 * radius, height: 2 * radius })) this.ring.style.setProperty(name, `${value}px`);
  }

  /** False: there is no surface. */
  private dab(x: number, y: number, { shiftKey, altKey }: PointerEvent): boolean {
    const { painting, stage, surfaces } = this;
    const hit = firstHit(surfaces, stage.ray(x, y));
    if (!hit) return false;
    const surface = surfaces[hit.object]!;
    const radius = painting.radius * stage.pixelAt(hit.point);
    const paints = !(painting.erases || shiftKey || altKey);
    const at = hit.point.clone();
    const away = (v: number) => surface.vertex(v, at).distanceToSquared(hit.point);
    const corners = [...surface.triangles.subarray(3 * hit.face, 3 * hit.face + 3)];
    painting.set(hit.object, corners.reduce((best, v) => (away(v) < away(best) ? v : best)), paints);
    for (const v of this.vertices[hit.object]!) if (away(v) <= radius * radius) painting.set(hit.object, v, paints);
    return true;
  }
}
