// The criteria of a result: each limit and each expectation, with what is known of it.
import type { Comparison, Directed, Side } from "../api/types.js";
import type { Witness } from "../viewer/settings.js";
import { plain, toDigitsAbove, toDigitsBelow, withUnits } from "./numbers.js";

export type Criterion = Comparison["criteria"][number];

/** One with an interval: of a distance, or of a share of the area. */
export type Limit = Criterion & Required<Pick<Criterion, "limit" | "lower" | "upper" | "uncertainty">>;

/** The region of what is in no other. */
export const rest = "rest";

export function isLimit(criterion: Criterion): criterion is Limit {
  return criterion.of !== "expectation";
}

/** In the order of the request; none: nothing was limited or expected. */
export function criteriaOf(result: Comparison): Criterion[] {
  const { criteria } = result as Partial<Comparison>;
  return criteria?.length ? criteria : ofOldResult(result);
}

/** The one to show where there is room for one: the worst, and of those the one farthest beyond its limit or nearest to it. */
export function foremostOf(result: Comparison): Criterion | null {
  const criteria = criteriaOf(result);
  return criteria.find(({ name }) => name === result.foremost) ?? criteria.find(({ verdict }) => verdict === result.verdict) ?? null;
}

// Results of before 0.2.0 have no criteria, and one limit.
function ofOldResult(result: Comparison): Criterion[] {
  const { gate, verdict, distance, status } = result;
  if (!verdict || !gate || gate.max_distance === null) return [];
  const [at] = witnessesOf(result);
  const witness = at ? { on: at.from, point: at.point, triangle: at.triangle, nearest_point: at.nearest, nearest_triangle: at.nearestTriangle } : null;
  return [{ name: "distance", of: "distance", verdict, finding: "", region: null, side: null, limit: gate.max_distance, uncertainty: 0, ...distance, status, witness }];
}

/** " ± 0.01 mm", what stands behind the limit; "": it has no uncertainty. */
export const plusMinus = ({ uncertainty }: Limit, units: string): string => (uncertainty ? ` ± ${withUnits(plain(uncertainty), units)}` : "");

/** The end of the limit's uncertainty that the verdict is about: for the digits that are shown, and for nothing else. */
export function shownLimit({ limit, uncertainty, verdict }: Limit): number {
  return verdict === "pass" ? limit - uncertainty : verdict === "fail" ? limit + uncertainty : limit;
}

/** Why a limit stays open where no more effort would decide it. */
export const whyOpen = ({ uncertainty }: Limit): string =>
  uncertainty > 0 ? "The interval lies within the uncertainty of the limit." : "The limit is within rounding error of the distance.";

/** "a limit of at least 0.0976 mm (pass) or below 0.0968 mm (fail)", those that the interval decides; "": none. */
export function decidingLimit({ lower, upper, uncertainty }: Limit, units: string): string {
  const parts: string[] = [];
  if (upper !== null) parts.push(`of at least ${withUnits(toDigitsAbove(upper + uncertainty, 6), units)} (pass)`);
  if (lower > uncertainty) parts.push(`below ${withUnits(toDigitsBelow(lower - uncertainty, 6), units)} (fail)`);
  return parts.length === 0 ? "" : `a limit ${parts.join(" or ")}`;
}

/** How many distances of the certified areas a limit asks for: none but a share's one, or both ends of an uncertain one. */
export const distancesAsked = ({ of, uncertainty }: Criterion): number => (of === "share" ? (uncertainty ? 2 : 1) : 0);

/** "", "In bore: ", "Outside of the regions: " */
export function placeWords({ region }: Criterion): string {
  if (!region) return "";
  return region === rest ? "Outside of the regions: " : `In ${region}: `;
}

/** One per direction that has one; the first attains the lower end of the interval. */
export function witnessesOf(result: Comparison): Witness[] {
  const found = [witnessOf("a", result.a_to_b), witnessOf("b", result.b_to_a)].filter((one) => one !== null);
  return found.sort((one, other) => other.lower - one.lower);
}

/** The same, but first the point of a limit that is not kept, as of a region or a side. */
export function witnessesToShow(result: Comparison): Witness[] {
  const found = witnessesOf(result), first = result.verdict === "pass" ? null : foremostWitness(result);
  return first ? [first, ...found.filter(({ from }) => from !== first.from)] : found;
}

// The foremost criterion may have no point, as an expectation.
function foremostWitness(result: Comparison): Witness | null {
  const worst = criteriaOf(result).filter((one) => one.verdict === result.verdict && one.witness);
  const shown = worst.find(({ name }) => name === result.foremost) ?? worst[0];
  if (!shown?.witness) return null;
  const { on, point, triangle, nearest_point, nearest_triangle } = shown.witness;
  return { from: on, point, nearest: nearest_point ?? point, lower: shown.lower ?? 0, upper: shown.upper ?? Infinity, triangle, nearestTriangle: nearest_triangle ?? 0 };
}

function witnessOf(from: Side, directed: Directed | null): Witness | null {
  if (!directed?.witness) return null;
  const { point_a, point_b, triangle_a, triangle_b } = directed.witness;
  const { lower, upper } = directed;
  return { from, point: point_a, nearest: point_b, lower, upper: upper ?? Infinity, triangle: triangle_a, nearestTriangle: triangle_b };
}
