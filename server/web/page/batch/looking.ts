// What is looked at of a batch's list. The browser's history keeps it, so that a step back leads to it.
import type { Filter } from "./rows.js";
import { filterWords } from "./words.js";

export interface Looking {
  filter: Filter | null; // null: nobody has chosen, what did not pass is shown while there is some
  search: string;
  from: number; // the page's first row
  opened: number | null; // the position of the row that was followed last
}

/** As it was kept; whatever else is there is taken for nothing. */
export function lookingOf(state: unknown): Looking {
  const { looking } = (typeof state === "object" && state !== null ? state : {}) as { looking?: Partial<Looking> };
  const { filter, search, from, opened } = looking ?? {};
  const isRow = (value: unknown): value is number => typeof value === "number" && Number.isInteger(value) && value >= 0;
  return {
    filter: typeof filter === "string" && Object.hasOwn(filterWords, filter) ? filter : null,
    search: typeof search === "string" ? search : "",
    from: isRow(from) ? from : 0,
    opened: isRow(opened) ? opened : null,
  };
}
