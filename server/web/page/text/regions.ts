// Regions of a result in words.
import type { Comparison } from "../api/types.js";
import { rest } from "./criteria.js";
import { withoutOverrides } from "./names.js";

type Region = NonNullable<Comparison["regions"]>[number];

export const regionName = ({ name }: Pick<Region, "name">): string => (name === rest ? "The rest" : withoutOverrides(name));

/** Where a region lies, in the numbers of the request, or its group's name; "": the rest. */
export function placeOf({ box, sphere, group }: Pick<Region, "box" | "sphere" | "group">): string {
  return box || sphere ? JSON.stringify(box ?? sphere) : withoutOverrides(group ?? "");
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
