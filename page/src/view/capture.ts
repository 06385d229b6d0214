// Saves pictures.
import { el } from '../shared/dom';

export function save(blob: Blob, name: string): void {
  const link = el('a', { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** A name for a file from the title of the motion. */
export const nameOf = (title: string, end: string): string => `${title.replace(/\.\w+$/, '').replace(/[^\w.-]+/g, '_') || 'foldproof'}${end}`;

export async function savePicture(picture: Promise<Blob | null>, title: string, position: string): Promise<void> {
  const blob = await picture;
  if (blob) save(blob, nameOf(title, `_${position}.png`));
}
