// What has a verdict of its own, a line each: expectations of the candidate, and regions.
import type { Comparison } from "../api/types.js";
import { h, tableCard } from "../dom.js";
import { intervalWords, plain, withUnits } from "../text/numbers.js";
import { placeOf, regionName } from "../text/regions.js";
import { unitsOf } from "../text/verdict.js";

/** What was found of the candidate itself; null: nothing is expected. */
export function expectationsOf({ expectations }: Comparison): HTMLElement | null {
  if (!expectations?.length) return null;
  const rows = expectations.map(({ name, found, expected, verdict }) => [name, found, expected, verdict]);
  return tableCard("Of the candidate (A) itself", ["Expectation", "Found", "Expected", "Verdict"], rows);
}

/** What was measured of each region and of the rest; null: no regions were asked for. */
export function regionsOf(result: Comparison): HTMLElement | null {
  const { regions } = result;
  if (!regions?.length) return null;
  const units = unitsOf(result);
  const rows = regions.map((region) => {
    const { lower, upper } = region.distance;
    const limit = region.max_distance ?? null;
    return [
      h("span", { title: placeOf(region) }, regionName(region)),
      region.empty ? "no surface" : intervalWords(lower, upper, units, limit),
      limit === null ? "" : withUnits(plain(limit), units),
      region.verdict,
    ];
  });
  return tableCard("Regions", ["Region", "Distance", "At most", "Verdict"], rows);
}
