// Contacts, as the program writes them.
export interface ContactFrame {
  time: number;
  crossings: number;
  triangles: number;
  curve_length: number;
  closed: boolean;
  depth: number | null;
}

/** What goes through what (docs/contacts.md). Times are frames of the motion. */
export interface Contact {
  number: number;
  joined: number[];
  sides: { object: number; name: string; triangles?: number[]; inside?: number[] }[];
  folded: boolean;
  from_start: boolean;
  healed: boolean;
  first_time: number;
  last_time: number;
  pairs: number;
  depth: number | null;
  worst: number | null; // the time of the worst frame
  point: [number, number, number];
  box: [number[], number[]];
  normal: number[];
  frames: ContactFrame[];
  curves?: number[][][];
}

export function worstOf(contact: Contact): ContactFrame | undefined {
  return contact.frames.find(({ time }) => time === contact.worst);
}
