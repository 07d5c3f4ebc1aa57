// What has a verdict of its own, a row each; without limits, what was measured of each region.
import type { Comparison } from "../api/types.js";
import { h, tableCard } from "../dom.js";
import { criteriaOf, isLimit, type Criterion } from "../text/criteria.js";
import { withoutOverrides } from "../text/names.js";
import { inPercentAbove, intervalText, intervalWords, plain, toDigitsBelow, withUnits } from "../text/numbers.js";
import { placeOf, regionName } from "../text/regions.js";
import { rangeOf, unitsOf } from "../text/verdict.js";

/** Null: the headline says it all, since there is one limit or none. */
export function criteriaTable(result: Comparison): HTMLElement | null {
  const criteria = criteriaOf(result);
  if (criteria.length < 2 && criteria.every(isLimit)) return null;
  const rows = criteria.map((one) => [nameCell(one, result), found(one, result), allowed(one, result), shareOfLimit(one), verdictCell(one)]);
  return tableCard("What is asked", ["Criterion", "Found", "Allowed", "Of the limit", "Verdict"], rows, "criteria");
}

function nameCell(criterion: Criterion, { regions }: Comparison): HTMLElement {
  const region = regions?.find(({ name }) => name === criterion.region);
  return h("span", region ? { title: placeOf(region) } : {}, withoutOverrides(criterion.name));
}

function verdictCell({ verdict }: Criterion): HTMLElement {
  return h("span", { class: `tone ${verdict}` }, verdict);
}

function found(criterion: Criterion, result: Comparison): string {
  if (!isLimit(criterion)) return criterion.found ?? "";
  if (criterion.refused) return withoutOverrides(`not known: ${criterion.refused}`);
  if (result.regions?.some(({ name, empty }) => name === criterion.region && empty)) return "no surface";
  return rangeOf(criterion, result);
}

function allowed(criterion: Criterion, result: Comparison): string {
  if (!isLimit(criterion)) return criterion.expected ?? "";
  const length = (one: number) => withUnits(plain(one), unitsOf(result));
  const more = criterion.uncertainty ? ` \u00B1 ${length(criterion.uncertainty)}` : "";
  if (criterion.of === "share") return `${intervalText(100 * criterion.lower, criterion.upper === null ? null : 100 * criterion.upper, 100 * criterion.limit).limit}\u00A0% beyond ${length(criterion.beyond ?? 0)}${more}`;
  return length(criterion.limit) + more;
}

// A fail is at least so much of its limit, all else at most.
function shareOfLimit(criterion: Criterion): string {
  if (!isLimit(criterion) || criterion.limit === 0 || criterion.refused) return "";
  const { lower, upper, limit, verdict } = criterion;
  const share = verdict === "fail" ? lower / limit : (upper ?? Infinity) / limit;
  if (!Number.isFinite(100 * share)) return "";
  return verdict === "fail" ? `\u2265 ${toDigitsBelow(100 * share, 3)}\u00A0%` : `\u2264 ${inPercentAbove(share, 3)}`;
}

/** What was measured of each region and of the rest; null: there are no regions, or a limit has them among the criteria. */
export function regionsOf(result: Comparison): HTMLElement | null {
  const { regions } = result;
  if (!regions?.length || criteriaOf(result).some(({ region }) => region)) return null;
  const rows = regions.map((region) => [
    h("span", { title: placeOf(region) }, regionName(region)),
    region.empty ? "no surface" : intervalWords(region.distance.lower, region.distance.upper, unitsOf(result)),
  ]);
  return tableCard("Regions", ["Region", "Distance"], rows);
}
