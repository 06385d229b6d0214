// What is shown, in the address of the page: a link shows the same again.
import type { Up } from '../shared/upright';

export interface UrlState {
  at: number | null; // position of the timeline
  contact: number | null; // a contact's number
  up: Up | null;
  camera: number[] | null; // the eye and what it looks at, in the scene
}

const kWriteMs = 300;

function numbers(text: string | null, count: number): number[] | null {
  const values = (text ?? '').split(',').map(Number);
  return text !== null && text !== '' && values.length === count && values.every(Number.isFinite) ? values : null;
}

export function readUrl(): UrlState {
  const parameters = new URLSearchParams(location.hash.slice(1));
  const up = parameters.get('up');
  return {
    at: numbers(parameters.get('at'), 1)?.[0] ?? null,
    contact: numbers(parameters.get('contact'), 1)?.[0] ?? null,
    up: up === 'y' || up === 'z' ? up : null,
    camera: numbers(parameters.get('camera'), 6),
  };
}

let timer = 0;

/** Writes it when nothing has changed for a moment. */
export function writeUrl(state: () => UrlState): void {
  clearTimeout(timer);
  timer = window.setTimeout(() => {
    const { at, contact, up, camera } = state();
    const parts = [at !== null && `at=${Number(at.toFixed(4))}`, contact !== null && `contact=${contact}`, up !== null && `up=${up}`, camera && `camera=${camera.map((value) => Number(value.toFixed(4))).join(',')}`];
    history.replaceState(null, '', `#${parts.filter(Boolean).join('&')}`);
  }, kWriteMs);
}
