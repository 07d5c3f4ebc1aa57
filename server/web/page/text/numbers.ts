// Formats numbers for users: few digits, rounded so that statements about the interval stay true.

import { withoutOverrides } from "./names.js";

const fewest = 4;
const enough = 6; // digits; bounds that agree in them need not be told apart
const most = 17; // digits that tell all doubles apart
const exact = 16; // a double's whole numbers have no more digits: write the number itself

/** True: null, as the service writes an unknown value, or not finite. */
export type Upper = number | null;

/** Returns "0.00012", "150000", "1.5e-12": fixed notation for the usual sizes. */
export function plain(x: number): string {
  if (Number.isNaN(x)) return "-";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "-∞";
  const size = Math.abs(x);
  if (size === 0) return "0";
  if (size >= 1e-4 && size < 1e9) return size >= 1e-6 ? String(x) : fixed(x);
  return x.toExponential().replace("e+", "e");
}

function fixed(x: number): string {
  return x.toFixed(20).replace(/0+$/, "");
}

interface Decimal {
  digits: number; // a whole number, in units of the last digit
  exponent: number;
}

const valueOf = (one: Decimal): number => Number(`${String(one.digits)}e${String(one.exponent)}`);

function nearest(x: number, digits: number): Decimal {
  const [mantissa = "0", exponent = "0"] = x.toExponential(digits - 1).split("e");
  return { digits: Number(mantissa.replace(".", "")), exponent: Number(exponent) - (digits - 1) };
}

/** Rounds x to so many significant digits, without zeros at the end. */
export function toDigits(x: number, digits: number): string {
  return Number.isFinite(x) ? plain(valueOf(nearest(x, digits))) : plain(x);
}

/** Rounds down: the number written is not above x. */
export function toDigitsBelow(x: number, digits: number): string {
  const decimal = nearest(x, digits);
  if (valueOf(decimal) > x) --decimal.digits;
  return digits >= exact ? plain(x) : plain(valueOf(decimal));
}

/** Rounds up: the number written is not below x. */
export function toDigitsAbove(x: number, digits: number): string {
  const decimal = nearest(x, digits);
  if (valueOf(decimal) < x) ++decimal.digits;
  return digits >= exact ? plain(x) : plain(valueOf(decimal));
}

export interface IntervalText {
  lower: string; // not above lower
  upper: string; // not below upper; "unknown" if it is
  limit: string; // "": there is none
}

/** Uses as few digits as tell the bounds apart and keep each on its side of the limit, both as written here and in full. */
export function intervalText(lower: number, upper: Upper, limit: number | null): IntervalText {
  const top = upper ?? Infinity;
  let text: IntervalText = { lower: "", upper: "", limit: "" };
  for (let digits = fewest; digits <= most; ++digits) {
    text = {
      lower: toDigitsBelow(lower, digits),
      upper: Number.isFinite(top) ? toDigitsAbove(top, digits) : "unknown",
      limit: limit === null ? "" : limitText(limit, digits),
    };
    if (isTrue(text, lower, top, limit, digits)) break;
  }
  return text;
}

function limitText(limit: number, digits: number): string {
  return plain(limit).length <= 10 ? plain(limit) : toDigits(limit, digits);
}

function isTrue(text: IntervalText, lower: number, upper: number, limit: number | null, digits: number): boolean {
  const low = Number(text.lower);
  const high = Number(text.upper);
  const end = Number(text.limit);
  const ends = limit === null ? [] : [limit, end];
  if (limit !== null && ends.some((one) => lower > limit !== low > one)) return false;
  if (!Number.isFinite(upper)) return true;
  if (limit !== null && ends.some((one) => upper <= limit !== high <= one)) return false;
  return digits >= enough || high - low <= 1.5 * (upper - lower);
}

/** Returns "0.09684 to 0.09766 mm", "0", "at least 0.2 mm", "not known yet". */
export function intervalWords(lower: number, upper: Upper, units: string, limit: number | null = null): string {
  const text = intervalText(lower, upper, limit);
  if (text.upper === "unknown") return lower > 0 ? `at least ${withUnits(text.lower, units)}` : "not known yet";
  if (text.lower === text.upper) return withUnits(text.lower, units);
  return `${text.lower} to ${withUnits(text.upper, units)}`;
}

export function withUnits(number: string, units: string): string {
  return units === "" ? number : `${number}\u00A0${withoutOverrides(units)}`;
}

/** "1,234,567" */
export function grouped(count: number): string {
  return String(Math.round(count)).replace(/\B(?=(\d{3})+$)/g, ",");
}

/** "1.4 MB" */
export function inBytes(bytes: number): string {
  const steps: [number, string][] = [[1e9, "GB"], [1e6, "MB"], [1e3, "kB"]];
  const step = steps.find(([size]) => bytes >= size);
  return step ? `${toDigits(bytes / step[0], 3)}\u00A0${step[1]}` : `${String(bytes)}\u00A0B`;
}

/** "1.4 s" */
export function inTime(ms: number): string {
  if (ms > 0 && ms < 0.01) return "<\u00A00.01\u00A0ms";
  if (ms < 1000) return `${toDigits(ms, ms < 10 ? 2 : 3)}\u00A0ms`;
  return ms < 120_000 ? `${toDigits(ms / 1000, 3)}\u00A0s` : `${toDigits(ms / 60_000, 3)}\u00A0min`;
}

/** For a running clock: "0.4 s", "12.3 s", "2 min 05 s"; its width changes little. */
export function onClock(ms: number): string {
  const seconds = ms / 1000;
  if (seconds < 100) return `${seconds.toFixed(1)}\u00A0s`;
  const whole = Math.floor(seconds);
  return `${String(Math.floor(whole / 60))}\u00A0min ${String(whole % 60).padStart(2, "0")}\u00A0s`;
}

const pointDigits = 7; // of the largest coordinate: 5.55e-17 beside 12.5 is 0; JSON has them all
const leastDecimals = 4; // far from the origin points stay apart

/** "(0.3227, 0.6693, 0.6693)" */
export function pointText(point: readonly number[]): string {
  const largest = Math.max(...point.map(Math.abs), Number.MIN_VALUE);
  const decimals = Math.min(Math.max(pointDigits - 1 - Math.floor(Math.log10(largest)), leastDecimals), 100);
  return `(${point.map((x) => plain(Number(x.toFixed(decimals)) + 0)).join(", ")})`;
}

/** "99.4 %": rounded up. */
export function inPercentAbove(share: number, digits: number): string {
  return `${toDigitsAbove(100 * share, digits)}\u00A0%`;
}

/** "99.3 %": rounded down, so that "100 %" is only ever exact. */
export function inPercent(share: number, digits = 4): string {
  const number = toDigits(100 * share, digits);
  return `${number === "100" && share < 1 ? "99.99" : number}\u00A0%`;
}
