// Regions of a result in words.
import type { Comparison } from "../api/types.js";
import { intervalText, plain, withUnits } from "./numbers.js";

type Region = NonNullable<Comparison["regions"]>[number];

const rest = "rest";

export const regionName = ({ name }: Pick<Region, "name">): string => (name === rest ? "The rest" : name);

/** Where a region lies, in the numbers of the request, or its group's name; "": the rest. */
export function placeOf({ box, sphere, group }: Pick<Region, "box" | "sphere" | "group">): string {
  return box || sphere ? JSON.stringify(box ?? sphere) : (group ?? "");
}

/** The result as if only the rest had been measured, which `max_distance` of the gate limits; without regions as it is. */
export function ofRest<Result extends Comparison>(result: Result): Result {
  const found = result.regions?.find(({ name }) => name === rest);
  if (!found) return result;
  return { ...result, distance: found.distance, a_to_b: directed(result.a_to_b, found.a_to_b), b_to_a: directed(result.b_to_a, found.b_to_a) };
}

function directed<Whole extends Comparison["a_to_b"]>(whole: Whole, found: Region["a_to_b"]): Whole {
  return whole && found ? { ...whole, ...found } : whole;
}

/** What is known of the regions that have the verdict, but for a pass of all; "": nothing. */
export function regionsSentence(result: Comparison, units: string): string {
  const { verdict } = result;
  const all = result.regions?.filter(({ name }) => name !== rest) ?? [];
  if (all.length === 0 || verdict === null) return "";
  const held = all.filter((region) => region.verdict === verdict);
  if (verdict === "pass") return all.length === 1 ? `So is ${regionName(all[0]!)}, within its own limit.` : "So is each region, within its own limit.";
  return held.map((region) => sentenceOf(region, units)).join(" ");
}

function sentenceOf(region: Region, units: string): string {
  const { lower, upper } = region.distance;
  const text = intervalText(lower, upper, region.max_distance ?? null);
  const limit = withUnits(plain(region.max_distance ?? 0), units);
  if (region.verdict === "fail") return `In ${region.name} a point is at least ${withUnits(text.lower, units)} away; at most ${limit} is allowed.`;
  return `In ${region.name} the distance lies between ${text.lower} and ${withUnits(text.upper, units)}: whether it is within ${limit} is not decided.`;
}

/** The regions as they were asked for: without those that have the gate's limit. */
export function regionsAsked({ regions, gate }: Comparison) {
  const asked = regions?.filter(({ name }) => name !== rest) ?? [];
  return asked.map(({ name, box, sphere, group, max_distance }) => ({
    name,
    ...(box ? { box } : {}),
    ...(sphere ? { sphere } : {}),
    ...(group ? { group } : {}),
    ...(max_distance === undefined || max_distance === gate?.max_distance ? {} : { max_distance }),
  }));
}
