// Settings with their defaults.
import { FoldproofError } from './types.js';

export const kStepDefaults = { within: true, between: true, thickness: 0, tolerance: 0, certificates: true, maxListed: 10_000_000 };
export const kCheckDefaults = { ...kStepDefaults, static: false, stepsOnly: false, contacts: true, substeps: 1 };
const kWhole = new Set(['maxListed', 'substeps']);
const kOfSteps = ['stepsOnly', 'substeps', 'thickness', 'tolerance'];

/**
 * All settings, as JSON for the engine. Throws an error for names that do not exist, values of a wrong kind, and settings of
 * steps with `poses`, what checks poses alone.
 */
export function settingsJson(defaults: Record<string, boolean | number>, given: Record<string, unknown>, poses = given.static === true ? 'static' : ''): string {
  const all: Record<string, unknown> = { ...defaults };
  for (const [name, value] of Object.entries(given)) {
    if (value === undefined) continue;
    if (!(name in defaults)) throw new FoldproofError(name, 'is not a setting', `settings are ${Object.keys(defaults).join(', ')}`);
    const kind = typeof defaults[name];
    if (typeof value !== kind) throw new FoldproofError(name, `is ${String(value)}`, `give a ${kind}`);
    if (kind === 'number' && !Number.isFinite(value)) throw new FoldproofError(name, `is ${String(value)}`, 'give a finite number');
    if (poses && kOfSteps.includes(name) && value !== defaults[name]) throw new FoldproofError(name, `does not go with ${poses}`, 'omit one of them');
    if (kWhole.has(name) && (!Number.isSafeInteger(value) || Number(value) < (name === 'substeps' ? 1 : 0))) throw new FoldproofError(name, `is ${String(value)}`, 'give a whole number');
    all[name] = value;
  }
  if (Number(all.substeps ?? 1) > 0xffffffff) throw new FoldproofError('substeps', `is ${String(all.substeps)}`, 'give a smaller number');
  return JSON.stringify(all);
}
