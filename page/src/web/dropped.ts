// Files and folders that are dropped or chosen.
import type { InputFile } from './messages';

export const chosen = (files: Iterable<File>): InputFile[] => [...files].map((file) => ({ path: file.webkitRelativePath || file.name, blob: file }));

const fileOf = (entry: FileSystemFileEntry): Promise<File> => new Promise((resolve, reject) => entry.file(resolve, reject));
const nextEntries = (reader: FileSystemDirectoryReader): Promise<FileSystemEntry[]> => new Promise((resolve, reject) => reader.readEntries(resolve, reject));

async function filesBelow(entry: FileSystemEntry): Promise<InputFile[]> {
  const path = entry.fullPath.replace(/^\//, '');
  if (entry.isFile) return [{ path, blob: await fileOf(entry as FileSystemFileEntry) }];
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  const files: InputFile[] = [];
  for (let entries = await nextEntries(reader); entries.length > 0; entries = await nextEntries(reader)) {
    for (const child of entries) if (!child.name.startsWith('.')) files.push(...(await filesBelow(child)));
  }
  return files;
}

export async function dropped(data: DataTransfer): Promise<InputFile[]> {
  // Entries are gone after the first await.
  const entries = [...data.items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
  return (await Promise.all(entries.map(filesBelow))).flat();
}
