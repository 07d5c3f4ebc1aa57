// A logarithmic axis of distances. 0 and unknown values have places of their own at its ends, since they have no logarithm.

export interface LogAxis {
  low: number; // positive and finite, below `high`
  high: number;
  zero: boolean; // the axis starts with a place for 0
  unknown: boolean; // the axis ends with a place for unknown values
}

/** null and infinite: unknown. */
export type Mark = number | null;

const endShare = 0.07; // share of the axis for each of the two places
const mostDecades = 12;
const leastDecades = 0.6;

/** Returns an axis that shows all marks with room on both sides. `whole`: end it at powers of ten, so that it rarely changes. */
export function axisFor(marks: readonly Mark[], whole = false): LogAxis {
  const known = marks.filter((mark): mark is number => mark !== null && Number.isFinite(mark) && mark > 0);
  const unknown = marks.some((mark) => mark === null || mark === Infinity);
  const zero = marks.some((mark) => mark === 0);
  if (known.length === 0) return { low: 0.1, high: 10, zero: true, unknown };
  const top = Math.log10(Math.max(...known));
  const bottom = Math.max(Math.log10(Math.min(...known)), top - mostDecades);
  const [low, high] = whole ? wholeDecades(bottom, top) : padded(bottom, top);
  return { low: tenTo(low), high: tenTo(high), zero, unknown };
}

function wholeDecades(bottom: number, top: number): [number, number] {
  const low = Math.floor(bottom - 0.05);
  return [low, Math.max(Math.ceil(top + 0.05), low + 1)];
}

function padded(bottom: number, top: number): [number, number] {
  const room = Math.max(0.12 * (top - bottom), (leastDecades - (top - bottom)) / 2, 0.1);
  return [bottom - room, top + room];
}

// Doubles end near 1e-308 and 1e308.
const tenTo = (exponent: number): number => 10 ** Math.min(Math.max(exponent, -300), 300);

/** Returns the place of a value: 0 at the start of the axis, 1 at its end; never beyond. */
export function positionOf(axis: LogAxis, mark: Mark): number {
  if (mark === null || mark === Infinity) return 1;
  if (!(mark > 0)) return 0;
  const [begin, end] = logarithmicPart(axis);
  const share = Math.log(mark / axis.low) / Math.log(axis.high / axis.low);
  return begin + (end - begin) * Math.min(Math.max(share, 0), 1);
}

/** Where the logarithmic part starts and ends. */
export function logarithmicPart(axis: LogAxis): [number, number] {
  return [axis.zero ? endShare : 0, axis.unknown ? 1 - endShare : 1];
}

export interface Tick {
  value: Mark;
  at: number; // from 0 to 1
  label: string; // "" for a tick between the numbers
}

/** Returns round numbers on the axis, at most `most` with a label, and the two ends if they have places. */
export function ticksOf(axis: LogAxis, most = 7): Tick[] {
  const labelled = roundNumbers(axis, most);
  const chosen = new Set(labelled);
  const between = steps(axis, 1, [1, 2, 3, 4, 5, 6, 7, 8, 9]).filter((value) => !chosen.has(value));
  const decades = Math.log10(axis.high / axis.low);
  const minor = decades <= 5 ? between : decades <= 12 ? steps(axis, 1, [1]).filter((value) => !chosen.has(value)) : [];
  const ticks: Tick[] = [
    ...labelled.map((value) => ({ value, at: positionOf(axis, value), label: label(value) })),
    ...minor.map((value) => ({ value, at: positionOf(axis, value), label: "" })),
  ];
  if (axis.zero) ticks.push({ value: 0, at: 0, label: "0" });
  if (axis.unknown) ticks.push({ value: null, at: 1, label: "∞" });
  return ticks.sort((one, other) => one.at - other.at);
}

function roundNumbers(axis: LogAxis, most: number): number[] {
  for (const mantissas of [[1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 5], [1, 3], [1]]) {
    const values = steps(axis, 1, mantissas);
    if (values.length <= most && values.length >= 2) return values;
  }
  if (steps(axis, 1, [1]).length > most) return thinned(axis, most);
  return linearSteps(axis, most);
}

function thinned(axis: LogAxis, most: number): number[] {
  for (let every = 2; ; ++every) {
    const values = steps(axis, every, [1]);
    if (values.length <= most) return values;
  }
}

// mantissa * 10^exponent on the axis, for each `every`-th exponent.
function steps(axis: LogAxis, every: number, mantissas: readonly number[]): number[] {
  const values: number[] = [];
  const first = Math.floor(Math.log10(axis.low));
  for (let exponent = first; exponent <= Math.log10(axis.high); ++exponent) {
    if (exponent % every !== 0) continue;
    for (const mantissa of mantissas) {
      const value = Number(`${String(mantissa)}e${String(exponent)}`);
      if (value >= axis.low * (1 - 1e-9) && value <= axis.high * (1 + 1e-9)) values.push(value);
    }
  }
  return values;
}

// For a short piece of the axis without a power of ten.
function linearSteps(axis: LogAxis, most: number): number[] {
  const step = niceStep((axis.high - axis.low) / Math.max(most - 1, 1));
  const values: number[] = [];
  for (let n = Math.ceil(axis.low / step); n * step <= axis.high; ++n) values.push(Number((n * step).toPrecision(12)));
  return values;
}

/** Returns 1, 2 or 5 times a power of ten, not below x. */
export function niceStep(x: number): number {
  const power = 10 ** Math.floor(Math.log10(x));
  const factor = [1, 2, 5].find((one) => one * power >= x * (1 - 1e-9)) ?? 10;
  return Number((factor * power).toPrecision(12));
}

function label(value: number): string {
  if (value >= 1e-4 && value < 1e6) return String(Number(value.toPrecision(10)));
  return value.toExponential().replace("e+", "e");
}
