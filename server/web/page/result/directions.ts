// The one-sided distances, each with its witness and statistics of the search.
import type { AreaBounds, Comparison, Directed, Distribution, Side } from "../api/types.js";
import { facts, h } from "../dom.js";
import { grouped, inPercent, intervalText, intervalWords, pointText, toDigits, withUnits } from "../text/numbers.js";
import { pieceOf, unitsOf } from "../text/verdict.js";

export function directionsOf(result: Comparison): HTMLElement {
  return h(
    "div",
    { class: "columns" },
    direction(result, "a", result.a_to_b, result.statistics?.a_to_b ?? null, result.areas?.a_to_b ?? null),
    direction(result, "b", result.b_to_a, result.statistics?.b_to_a ?? null, result.areas?.b_to_a ?? null),
  );
}

function direction(result: Comparison, from: Side, directed: Directed | null, sampled: Distribution | null, areas: AreaBounds | null): HTMLElement {
  const [one, other] = from === "a" ? ["A", "B"] : ["B", "A"];
  const title = h("h3", {}, `From ${one} to ${other}`);
  if (!directed) return h("div", {}, title, h("p", { class: "hint" }, "Not requested."));
  const units = unitsOf(result);
  const piece = pieceOf(result, from);
  const smaller = result.status === "converged" && result.direction === "symmetric" && directed.lower < result.distance.lower;
  return h(
    "div",
    {},
    title,
    h("p", { class: "figure" }, intervalWords(directed.lower, directed.upper, units)),
    smaller ? h("p", { class: "hint" }, "Searched only as far as it could be the larger of the two.") : null,
    directed.work.nearest_queries === 0 ? h("p", { class: "hint" }, unsearched(result, directed, one, other)) : null,
    directed.work.nearest_queries === 0 ? null : facts([...witnessFacts(directed, one, other, units, piece), ...searchFacts(directed, piece)]),
    areas ? certified(areas, units) : null,
    sampled ? samples(sampled, units) : null,
  );
}

/** Why no point was measured: it was not needed, or time ran out. */
export function unsearched(result: Comparison, directed: Directed, one: string, other: string): string {
  if (directed.upper === 0) return `Proved without a search: the surface of ${one} is the same as that of ${other}, or a part of it.`;
  if (result.status === "converged") return "Proved without a search: bounds of whole triangles were enough.";
  return "The work ended before this direction was searched.";
}

type Facts = Parameters<typeof facts>[0];

function witnessFacts(directed: Directed, one: string, other: string, units: string, piece: string): Facts {
  const { witness } = directed;
  if (!witness) return [["Witness", "No point was measured"]];
  return [
    [`A point at least ${withUnits(intervalText(directed.lower, directed.upper, null).lower, units)} away, on ${one}`, `${withUnits(pointText(witness.point_a), units)}, ${piece} ${String(witness.triangle_a)}`],
    [`Nearest to it, on ${other}`, `${withUnits(pointText(witness.point_b), units)}, triangle ${String(witness.triangle_b)}`],
  ];
}

function searchFacts(directed: Directed, piece: string): Facts {
  const { culling, work } = directed;
  return [
    ["Culled at once", `${inPercent(culling.rate)} of ${grouped(culling.triangles)} ${piece}s; ${grouped(culling.survivors)} were looked at closely`],
    ["Work", `${grouped(work.nearest_queries)} nearest points, ${grouped(work.triangle_tests)} triangle tests, ${grouped(work.subdivisions)} pieces split`],
  ];
}

function certified(areas: AreaBounds, units: string): HTMLElement {
  const length = (one: { lower: number; upper: number | null }) => intervalWords(one.lower, one.upper, units);
  return h(
    "div",
    { class: "sampled" },
    h("h4", {}, "Of the area, certified"),
    facts([
      ...areas.beyond.map(({ distance, share }): [string, string] => [
        `Farther than ${withUnits(String(distance), units)}`,
        `${outwards(share.lower, Math.floor)} to ${outwards(share.upper ?? 1, Math.ceil)} %`,
      ]),
      ...areas.quantiles.map(({ share, distance }): [string, string] => [`${toDigits(100 * share, 4)} % are within`, length(distance)]),
      ...(areas.mean ? [["Mean", length(areas.mean)] as [string, string]] : []),
      ...(areas.rms ? [["Root mean square", length(areas.rms)] as [string, string]] : []),
    ]),
  );
}

/** A share in percent with three decimals, rounded outwards. */
function outwards(share: number, round: (x: number) => number): string {
  return (round(share * 1e5) / 1e3).toFixed(3);
}

function samples(sampled: Distribution, units: string): HTMLElement {
  const value = (one: { value: number }) => withUnits(toDigits(one.value, 4), units);
  return h(
    "div",
    { class: "sampled" },
    h("h4", {}, `${sampled.weight === "points" && sampled.mean.standard_error === 0 ? "Of" : "Sampled at"} ${grouped(sampled.samples)} points, not certified`),
    facts([
      ["Mean", value(sampled.mean)],
      ["Root mean square", value(sampled.rms)],
      ["Half is within", value(sampled.p50)],
      ["95 % are within", value(sampled.p95)],
      ["99 % are within", value(sampled.p99)],
      ["Largest seen", withUnits(toDigits(sampled.max_seen, 4), units)],
    ]),
  );
}
