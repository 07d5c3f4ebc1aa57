// Formats numbers for users.

// About `digits` digits, without an exponent where that is readable.
export function figure(value: number, digits = 4): string {
  if (!Number.isFinite(value)) return "unknown";
  return readable(Number(value.toPrecision(digits)));
}

// Large numbers get an exponent, as small ones do by themselves.
function readable(value: number): string {
  return Math.abs(value) >= 1e9 ? value.toExponential().replace("e+", "e") : String(value);
}

// As `figure`, rounded down, for "at least".
export function atLeast(value: number, digits = 4): string {
  if (!(value > 0)) return "0";
  const exponent = Math.floor(Math.log10(value)) - digits + 1;
  let rounded = Number(value.toPrecision(digits));
  if (rounded > value) rounded = Number((rounded - 10 ** exponent).toPrecision(digits));
  return readable(rounded);
}

export function withUnits(text: string, units: string): string {
  return units ? `${text} ${units}` : text;
}

export const count = (value: number): string => value.toLocaleString("en-GB");

// A share as "3.2 %"; "0 %" and "100 %" are only ever exact.
export function percent(share: number): string {
  if (share <= 0) return "0 %";
  if (share >= 1) return "100 %";
  if (share < 0.0001) return "less than 0.01 %";
  if (share > 0.9999) return "more than 99.99 %";
  const hundredths = 100 * share;
  return `${share > 0.99 ? hundredths.toFixed(2) : Number(hundredths.toPrecision(3))} %`;
}
