// Light or dark: the system's setting, until the user changes it.
import { el, icon } from './dom';

const kKey = 'foldproof-theme';
type Listener = (dark: boolean) => void;
const listeners: Listener[] = [];
const system = matchMedia('(prefers-color-scheme: dark)');

function stored(): string | null {
  try {
    return localStorage.getItem(kKey);
  } catch {
    return null; // A file:// page may have no storage.
  }
}

export const isDark = (): boolean => document.documentElement.dataset['theme'] === 'dark';

/** Applies the stored setting, or the system's. */
export function applyTheme(): void {
  const choice = stored();
  const dark = choice === null ? system.matches : choice === 'dark';
  document.documentElement.dataset['theme'] = dark ? 'dark' : 'light';
  for (const listener of listeners) listener(dark);
}

export function toggleTheme(): void {
  const next = isDark() ? 'light' : 'dark';
  try {
    localStorage.setItem(kKey, next);
    applyTheme();
  } catch {
    document.documentElement.dataset['theme'] = next;
    for (const listener of listeners) listener(next === 'dark');
  }
}

export function startTheme(): void {
  system.addEventListener('change', applyTheme);
  applyTheme();
}

export const onTheme = (listener: Listener): void => void listeners.push(listener);

export function themeButton(): HTMLButtonElement {
  return el(
    'button',
    { className: 'quiet', type: 'button', title: 'Light or dark (D)', 'aria-label': 'Switch between light and dark', onclick: toggleTheme },
    icon('M12 3a9 9 0 1 0 9 9 7 7 0 0 1-9-9z'),
  );
}
