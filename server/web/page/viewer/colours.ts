// The colour map of api/map/colour_map.h, byte for byte (tests/web/unit/colours.json checks both), with its ticks: from dark
// violet over blue and green to light yellow at the limit, one dark red above it. Where sides are known there are two other
// paths, from the same grey at 0: to orange outside, to blue inside.

export type Rgb = readonly [number, number, number]; // sRGB, 0 to 255

export const kAboveLimit: Rgb = [190, 12, 0];
const kInsideAboveLimit: Rgb = [52, 0, 120];

export type Path = "plain" | "outside" | "inside";
export const kPaths: readonly Path[] = ["plain", "outside", "inside"]; // rows of the table
export const aboveLimit = (path: Path): Rgb => (path === "inside" ? kInsideAboveLimit : kAboveLimit);
export type SideOfB = Exclude<Path, "plain">;
export const kSteps = 1024; // of the map; a share is rounded to the nearest one

export interface SideLimit {
  limit: number; // of A on that side of B, not negative
  lower: number; // proved: A reaches as far there
}

export interface ColourScale {
  top: number; // distance of the last colour, not negative
  limited: boolean; // `top` is a limit, and larger distances get kAboveLimit
  sideLimits?: Record<SideOfB, SideLimit>;
}

// The distance above which a path has its last colour; infinite: none.
export function limitOf({ top, limited, sideLimits }: ColourScale, path: Path): number {
  return Math.min(limited ? top : Infinity, path === "plain" || !sideLimits ? Infinity : sideLimits[path].limit);
}

// A helix in OKLab; api/map/colour_map.cpp explains its numbers.
function helix(share: number): [number, number, number] {
  const hue = ((300 + (115 - 300) * share) * Math.PI) / 180;
  return [0.25 + (0.93 - 0.25) * share, 0.02 + 0.12 * Math.cos(hue), 0.01 + 0.12 * Math.sin(hue)];
}

// From a light grey, which a white page and a dark one show, to this lightness, a and b, in OKLab.
function towards(share: number, end: readonly [number, number, number]): [number, number, number] {
  return [0.86 + (end[0] - 0.86) * share, end[1] * share, end[2] * share];
}

const okLab: Record<Path, (share: number) => [number, number, number]> = {
  plain: helix,
  outside: (share) => towards(share, [0.62, 0.09, 0.13]),
  inside: (share) => towards(share, [0.5, -0.04, -0.17]),
};

function linearOf([lightness, a, b]: [number, number, number]): [number, number, number] {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
}

function encoded(linear: number): number {
  const c = Math.min(Math.max(linear, 0), 1);
  return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
}

let table: Uint8Array | undefined;

// RGBA of kSteps + 1 colours of each path, the shader's lookup table.
export function colourTable(): Uint8Array {
  if (table) return table;
  table = new Uint8Array(4 * (kSteps + 1) * kPaths.length).fill(255);
  kPaths.forEach((path, row) => {
    for (let i = 0; i <= kSteps; ++i) table!.set(linearOf(okLab[path](i / kSteps)).map(encoded), 4 * (row * (kSteps + 1) + i));
  });
  return table;
}

export function mapColour(share: number, path: Path = "plain"): Rgb {
  const row = kPaths.indexOf(path) * (kSteps + 1);
  const at = 4 * (row + Math.round((share > 0 ? Math.min(share, 1) : 0) * kSteps));
  const colours = colourTable();
  return [colours[at]!, colours[at + 1]!, colours[at + 2]!];
}

export function colourOf(distance: number, scale: ColourScale, path: Path = "plain"): Rgb {
  if (distance <= 0) return mapColour(0, path);
  if (distance > limitOf(scale, path)) return aboveLimit(path);
  return mapColour(distance / scale.top, path);
}

export const css = ([r, g, b]: Rgb): string => `rgb(${r}, ${g}, ${b})`;

const decimal = (count: number, exponent: number): number =>
  exponent < 0 ? count / 10 ** -exponent : count * 10 ** exponent;

// The rule of legend_ticks in api/map/colour_map.h: three to seven round numbers, 1, 2 or 5 times a power of ten apart, and
// the top; none so near to the top that labels would touch.
export function ticks(top: number): number[] {
  if (!(top > 1e-290 && top < 1e290)) return [0];
  const exponent = Math.floor(Math.log10(top)) - 1;
  const steps: [number, number][] = [
    [1, exponent],
    [2, exponent],
    [5, exponent],
    [1, exponent + 1],
    [2, exponent + 1],
  ];
  const [digit, power] = steps.find(([d, e]) => top / decimal(d, e) < 6.5) ?? [5, exponent + 1];
  const width = decimal(digit, power);
  const all = [0];
  for (let i = 1; i * width < top - 0.4 * width; ++i) all.push(decimal(i * digit, power));
  return [...all, top];
}
