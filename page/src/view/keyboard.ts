// Keyboard shortcuts, except in fields that use the keys themselves.

export type KeyActions = Record<string, (event: KeyboardEvent) => void>;

export function listen(actions: KeyActions): void {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector('dialog[open]')) return;
    const target = event.target as HTMLElement;
    const typing = target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && (target.type === 'range' || target.type === 'radio'));
    if (typing && /^(Arrow|Home|End|Page)/.test(event.key)) return;
    if (event.key === ' ' && (target instanceof HTMLButtonElement || target instanceof HTMLInputElement)) return;
    const action = actions[(event.shiftKey && event.key.length > 1 ? 'Shift+' : '') + event.key];
    if (!action) return;
    event.preventDefault();
    action(event);
  });
}
