// What the visible surfaces say about the limit, in one or two sentences: of both, since one may be within the limit while
// the comparison fails.
import type { Path } from "./colours";
import { figure, percent, withUnits } from "./figures";
import { nameOf, other, type Side, type Witness } from "./settings";

export interface Beyond {
  farther: boolean; // any visible part of it is beyond the limit
  share: number; // of its area or points
  of?: "area" | "points";
  zone?: string; // zoneWords(), where the sides have limits
}

// How far A is beyond the limit of one side of B.
export interface OneSide extends Omit<Beyond, "zone"> {
  side: Exclude<Path, "plain">;
  limit: number;
  lower: number; // proved: A reaches as far
}

export const isBeyond = ({ farther, lower, limit }: OneSide): boolean => farther || lower > limit;

export function zoneWords(sides: readonly OneSide[], units: string): string {
  const said = sides.filter(isBeyond).map(({ side, limit, share, farther, of = "area" }) => {
    const where = `more than ${withUnits(figure(limit), units)} ${side} of B`;
    return farther ? `${percent(Math.max(share, 1e-9))} of A’s ${of} ${of === "area" ? "is" : "are"} ${where}` : `A reaches ${where}, where it is too small to show`;
  });
  return said.length === 0 ? "All of A that is shown is within the limits of both sides." : `${said.join(", and ")}.`;
}

interface Shown {
  coloured: Side;
  split: boolean;
}

// `limit`: of both surfaces; null: A alone has limits, of its sides.
export function limitWords({ coloured, split }: Shown, beyond: Record<Side, Beyond>, witnesses: readonly Witness[], limit: number | null): string {
  if (limit === null) return capital(beyond.a.zone ?? "");
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

function sentence(side: Side, state: State, { share, of = "area", zone }: Beyond): string {
  const [one, two] = [nameOf(side), nameOf(other(side))];
  if (zone && state === "area") return zone;
  if (state === "within") return `All of ${one} that is shown is within the limit.`;
  if (state === "point") return `The witness of ${one} is farther from ${two} than the limit; the area around it is too small to show.`;
  return `${percent(Math.max(share, 1e-9))} of ${one}’s ${of} ${of === "area" ? "is" : "are"} farther from ${two} than the limit.`;
}

const capital = (text: string): string => text.slice(0, 1).toUpperCase() + text.slice(1);
