// What was measured of each region and of the rest, a line each.
import type { Comparison } from "../api/types.js";
import { card, h, scroller } from "../dom.js";
import { intervalWords, plain, withUnits } from "../text/numbers.js";
import { placeOf, regionName } from "../text/regions.js";
import { unitsOf } from "../text/verdict.js";

/** null: no regions were asked for. */
export function regionsOf(result: Comparison): HTMLElement | null {
  const { regions } = result;
  if (!regions?.length) return null;
  const units = unitsOf(result);
  const rows = regions.map((region) => {
    const { lower, upper } = region.distance;
    const limit = region.max_distance ?? null;
    return h(
      "tr",
      {},
      h("th", { scope: "row", title: placeOf(region) }, regionName(region)),
      h("td", {}, region.empty ? "no surface" : intervalWords(lower, upper, units, limit)),
      h("td", {}, limit === null ? "" : withUnits(plain(limit), units)),
      h("td", {}, region.verdict ?? ""),
    );
  });
  const head = h("tr", {}, ...["Region", "Distance", "At most", "Verdict"].map((name) => h("th", { scope: "col" }, name)));
  return card("Regions", { class: "card" }, scroller("Regions", h("table", { class: "regions" }, h("thead", {}, head), h("tbody", {}, ...rows))));
}
