// Numbers in readable form.

const kGrouped = new Intl.NumberFormat('en-US', { maximumFractionDigits: 0 });

export const grouped = (value: number): string => kGrouped.format(value);

export const counted = (value: number, noun: string, plural = `${noun}s`): string =>
  `${grouped(value)} ${value === 1 ? noun : plural}`;

const kOrdinals = new Intl.PluralRules('en', { type: 'ordinal' });
const kEndings: Partial<Record<Intl.LDMLPluralRule, string>> = { one: 'st', two: 'nd', few: 'rd' };

/** "2nd" */
export const ordinal = (value: number): string => `${value}${kEndings[kOrdinals.select(value)] ?? 'th'}`;

/** Four significant digits, as plain as possible. */
export function short(value: number): string {
  if (!Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(2);
  return size >= 1000 ? grouped(value) : String(Number(value.toPrecision(4)));
}

/** For axes: 12,000 is 12k. */
export function brief(value: number): string {
  const size = Math.abs(value);
  if (size >= 1e9) return `${Number((value / 1e9).toPrecision(3))}G`;
  if (size >= 1e6) return `${Number((value / 1e6).toPrecision(3))}M`;
  if (size >= 1e4) return `${Number((value / 1e3).toPrecision(3))}k`;
  return String(Number(value.toPrecision(3)));
}

export const milliseconds = (value: number): string => {
  if (value < 999.5) return `${value < 1 ? value.toFixed(2) : value.toPrecision(3)} ms`;
  if (value < 119_500) return `${(value / 1000).toPrecision(3)} s`;
  const seconds = Math.round(value / 1000);
  if (seconds < 7200) return `${Math.floor(seconds / 60)} min ${seconds % 60} s`;
  const minutes = Math.round(seconds / 60);
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
};

export const percent = (share: number): string => {
  if (share > 0 && share < 0.001) return '< 0.1 %';
  if (share < 1 && share > 0.999) return '> 99.9 %';
  return `${(100 * share).toFixed(1)} %`;
};

export const toiText = (toi: number): string => toi.toFixed(4);

const kMetric = [['km', 1e3], ['m', 1], ['cm', 1e-2], ['mm', 1e-3], ['um', 1e-6], ['nm', 1e-9]] as const;

/** Two digits, without an exponent where that is short. */
function twoDigits(value: number): string {
  const size = Math.abs(value);
  if (size === 0) return '0';
  if (size >= 1e6 || size < 1e-4) return value.toExponential(1).replace('.0e', 'e');
  return String(Number(value.toPrecision(2)));
}

/** A length in the metric unit that fits it, or in `unit`: length_text() of the program. */
export function lengthText(length: number, unit: string): string {
  const known = kMetric.find(([name]) => name === unit);
  if (!known) return twoDigits(length) + (unit ? ` ${unit}` : '');
  const meters = length * known[1];
  const [name, size] = length > 0 ? (kMetric.find(([, each]) => meters >= 0.995 * each) ?? kMetric.at(-1)!) : known;
  return `${twoDigits(meters / size)} ${name}`;
}
