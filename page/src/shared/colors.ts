// All colors with a meaning. Okabe and Ito's colors and even steps of lightness are distinguishable with color vision
// deficiency.

export type Rgb = [number, number, number];

export const kRed: Rgb = [213, 44, 0];
export const kClay: Rgb = [196, 192, 186];
export const kBlue: Rgb = [0, 114, 178];
export const kSky: Rgb = [86, 180, 233];
export const kGreen: Rgb = [0, 158, 115];
export const kYellow: Rgb = [240, 228, 66];
export const kOrange: Rgb = [230, 159, 0];
export const kPink: Rgb = [204, 121, 167];
export const kGray: Rgb = [128, 128, 128];
export const kNothingToProve: Rgb = [221, 221, 221];

/** A light shade per object, on which marks of every other color are visible. */
export const kObjectColors: Rgb[] = [kClay, [170, 190, 200], [200, 186, 160], [184, 180, 204], [176, 198, 176]];

/** Reasons by their names in docs/reports.md: color, title and help text. */
export const kReasons: Record<string, { color: Rgb; title: string; help: string }> = {
  certified: { color: [0, 84, 142], title: 'Proven free', help: 'nothing had to be tested' },
  not_built: { color: kYellow, title: 'Not built yet', help: 'its chart has not been built' },
  test_failed: { color: kOrange, title: 'Moved too far from its charts', help: 'smaller movements or a model help' },
  overlapping: { color: kGreen, title: 'Overlaps in the plane', help: 'the last attempt found no parametrization without overlaps' },
  too_curved: { color: kPink, title: 'Too curved', help: 'no direction that all its triangles face; a finer mesh helps' },
  near_other: { color: [213, 94, 0], title: 'Near another part', help: 'too near for a separating plane: these pairs must be tested' },
  off: { color: kGray, title: 'Certificates off', help: 'the check ran without them' },
};

/** The color of a certified triangle: paler for deeper levels of the chart that proved it. */
export function levelColor(level: number): Rgb {
  if (level < 0) return kNothingToProve;
  const pale = Math.min(level, 15) * 12;
  return [pale, 60 + pale, Math.trunc(128 + (pale * 2) / 3)];
}

type Lab = [number, number, number]; // Oklab (Ottosson 2020)

const kErrorStops: Lab[] = [
  [0.9, 0.002, 0.01],
  [0.75, 0.055, 0.135],
  [0.6, 0.15, 0.085],
  [0.45, 0.155, -0.02],
  [0.3, 0.07, -0.09],
];
// Blue throughout: the other hues mark reasons.
const kMarginStops: Lab[] = [
  [0.26, 0, -0.11],
  [0.43, -0.02, -0.14],
  [0.6, -0.045, -0.115],
  [0.77, -0.06, -0.075],
  [0.93, -0.055, -0.03],
];
const kTimeStops: Lab[] = [
  [0.93, -0.03, 0.15],
  [0.77, -0.12, 0.03],
  [0.62, -0.04, -0.13],
  [0.55, 0.1, -0.16],
];

const encode = (light: number): number => {
  const v = Math.min(1, Math.max(0, light));
  return 255 * (v <= 0.0031308 ? v * 12.92 : 1.055 * v ** (1 / 2.4) - 0.055);
};

function toRgb([lightness, a, b]: Lab): Rgb {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    encode(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    encode(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    encode(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

function ramp(stops: Lab[]): (value: number) => Rgb {
  return (value) => {
    const position = Math.min(1, Math.max(0, Number.isFinite(value) ? value : 0)) * (stops.length - 1);
    const k = Math.min(Math.floor(position), stops.length - 2);
    const [from, to] = [stops[k]!, stops[k + 1]!];
    const mix = (i: 0 | 1 | 2) => from[i] + (position - k) * (to[i] - from[i]);
    return toRgb([mix(0), mix(1), mix(2)]);
  };
}

export const errorColor = ramp(kErrorStops);
export const marginColor = ramp(kMarginStops);
/** Contact points: from yellow for the start of the step to violet for its end, seen on light and on dark ground. */
export const timeColor = ramp(kTimeStops);

export const css = ([r, g, b]: Rgb): string => `rgb(${Math.round(r)} ${Math.round(g)} ${Math.round(b)})`;

export const gradient = (color: (value: number) => Rgb): string =>
  `linear-gradient(90deg, ${Array.from({ length: 9 }, (_, k) => css(color(k / 8))).join(', ')})`;
