// The state of a batch's list, kept in the browser's history, so that going back restores it.
import type { Filter } from "./rows.js";
import { filterWords } from "./words.js";

export interface ListState {
  filter: Filter | null; // null: not chosen; comparisons that did not pass are shown as long as there are any
  search: string;
  from: number; // first row of the page
  opened: number | null; // position of the row that was opened last
}

/** Reads the state from the history; anything else is ignored. */
export function listStateOf(state: unknown): ListState {
  const { listState } = (typeof state === "object" && state !== null ? state : {}) as { listState?: Partial<ListState> };
  const { filter, search, from, opened } = listState ?? {};
  const isRow = (value: unknown): value is number => typeof value === "number" && Number.isInteger(value) && value >= 0;
  return {
    filter: typeof filter === "string" && Object.hasOwn(filterWords, filter) ? filter : null,
    search: typeof search === "string" ? search : "",
    from: isRow(from) ? from : 0,
    opened: isRow(opened) ? opened : null,
  };
}
