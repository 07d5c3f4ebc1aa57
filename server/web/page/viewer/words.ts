// The words and numbers beside the picture: figures, what the visible surfaces say about the limit, notes on the picture.
import type { SideLimit, SideOfB } from "./colours";
import { nameOf, other, type Settings, type Side, type ViewerInput, type Witness } from "./settings";

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

const count = (value: number): string => value.toLocaleString("en-GB");

// A share as "3.2 %"; "0 %" and "100 %" are only ever exact.
export function percent(share: number): string {
  if (share <= 0) return "0 %";
  if (share >= 1) return "100 %";
  if (share < 0.0001) return "less than 0.01 %";
  if (share > 0.9999) return "more than 99.99 %";
  const hundredths = 100 * share;
  return `${share > 0.99 ? hundredths.toFixed(2) : Number(hundredths.toPrecision(3))} %`;
}

export interface Beyond {
  farther: boolean; // any visible part of it is beyond the limit
  share: number; // of its area or points
  of?: "area" | "points";
  ofSides?: string; // sideWords(), where the sides have limits
}

// How far A is beyond the limit of one side of B.
export interface OneSide extends Omit<Beyond, "ofSides">, SideLimit {
  side: SideOfB;
}

export const isBeyond = ({ farther, lower, limit }: OneSide): boolean => farther || lower > limit;

export function sideWords(sides: readonly OneSide[], units: string): string {
  const said = sides.filter(isBeyond).map(({ side, limit, share, farther, of = "area" }) => {
    const where = `more than ${withUnits(figure(limit), units)} ${side} of B`;
    return farther ? `${percent(Math.max(share, 1e-9))} of A’s ${of} ${of === "area" ? "is" : "are"} ${where}` : `A reaches ${where}, where it is too small to show`;
  });
  return said.length === 0 ? "All of A that is shown is within the limits of both sides." : `${said.join(", and ")}.`;
}

// What the visible surfaces say about the limit, in one or two sentences: of both, since one may be within the limit while
// the comparison fails. `limit`: of both surfaces; null: A alone has limits, of its sides.
export function limitWords({ coloured, split }: Pick<Settings, "coloured" | "split">, beyond: Record<Side, Beyond>, witnesses: readonly Witness[], limit: number | null): string {
  if (limit === null) return capital(beyond.a.ofSides ?? "");
  const hidden = other(coloured);
  const state = { a: stateOf("a", beyond.a, witnesses, limit), b: stateOf("b", beyond.b, witnesses, limit) };
  if (state.a === "within" && state.b === "within") return "All of A and of B that is shown is within the limit.";
  const tells = (side: Side): string => capital(sentence(side, state[side], beyond[side]));
  if (state[coloured] !== "within") return state[hidden] === "within" || !split ? tells(coloured) : `${tells(coloured)} ${tells(hidden)}`;
  const [one, two] = [nameOf(coloured), nameOf(hidden)];
  const look = split ? "" : ` “Swap” colours ${two}.`;
  return `All of ${one} that is shown is within the limit; ${two} is not: ${sentence(hidden, state[hidden], beyond[hidden])}${look}`;
}

type State = "within" | "area" | "point";

// A surface decimated for display may have lost what is beyond the limit; the witness is of the whole mesh.
function stateOf(side: Side, { farther }: Beyond, witnesses: readonly Witness[], limit: number): State {
  if (farther) return "area";
  return witnesses.some(({ from, lower }) => from === side && lower > limit) ? "point" : "within";
}

function sentence(side: Side, state: State, { share, of = "area", ofSides }: Beyond): string {
  const [one, two] = [nameOf(side), nameOf(other(side))];
  if (ofSides && state === "area") return ofSides;
  if (state === "within") return `All of ${one} that is shown is within the limit.`;
  if (state === "point") return `The witness of ${one} is farther from ${two} than the limit; the area around it is too small to show.`;
  return `${percent(Math.max(share, 1e-9))} of ${one}’s ${of} ${of === "area" ? "is" : "are"} farther from ${two} than the limit.`;
}

const capital = (text: string): string => text.slice(0, 1).toUpperCase() + text.slice(1);

function noteOn(side: Side, input: ViewerInput): string | undefined {
  const { display, indices, cloud } = input[side];
  const shown = indices.length / 3;
  const name = nameOf(side);
  if (cloud) {
    const part = display.form === "decimated" ? `; ${count(shown)} are shown. The numbers are of all` : "";
    return `${name} is a point cloud of ${count(display.vertices)} points${part}.`;
  }
  if (display.form === "decimated") {
    return `${name} has ${count(display.triangles)} triangles; ${count(shown)} are shown. The numbers are of the whole mesh.`;
  }
  if (display.form === "refined") {
    return `${name} has ${count(display.triangles)} triangles, refined for display to ${count(shown)}, so that colours show what lies between its vertices.`;
  }
  if (shown === 0) return `${name} has no triangles to show.`;
  return undefined;
}

// What users must know about the picture, in sentences.
export function notesOf(input: ViewerInput): string[] {
  const notes = (["a", "b"] as Side[]).map((side) => noteOn(side, input)).filter((note) => note !== undefined);
  if (input.a.noSides) notes.push(`A has no sides of B: ${input.a.noSides.replace("the baseline", "B")}.`);
  return [...notes, "Colours are computed at vertices, not certified; the interval is."];
}
