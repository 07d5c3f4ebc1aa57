// The comparisons of a batch: counts that act as filters, a search by name, and a page of rows.
import { button, h, scroller, type Announcer } from "../dom.js";
import { scaleFor, strip, stripStripes, type StripScale } from "../plot/strip.js";
import { pathOf } from "../route.js";
import { grouped, intervalWords } from "../text/numbers.js";
import { asSentence, explain } from "../text/problems.js";
import { isAbort } from "../api/client.js";
import { iconOf } from "../result/icon.js";
import type { Filter, Row, RowSource } from "./rows.js";
import { filterWords, pageWords, toneOf } from "./words.js";

/** The state of a list, kept in the browser's history, so that going back restores it. */
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

const pageRows = 50;
const always: readonly Filter[] = ["open", "all", "fail", "undecided", "error", "pass"];
const filters: readonly Filter[] = [...always, "cancelled", "gone", "measured"];
const searchPauseMs = 150;

export class BatchList {
  readonly element: HTMLElement;
  private readonly tiles = new Map<Filter, { tile: HTMLButtonElement; count: HTMLElement }>();
  private readonly search = h("input", { id: "row-search", type: "search", autocomplete: "off", spellcheck: "false" });
  private readonly words = h("p", { class: "hint list-words" });
  private readonly trouble = h("div", { role: "status" });
  private readonly body = h("tbody");
  private readonly table: HTMLTableElement;
  private readonly earlier = button("Previous", {}, () => this.turn(-pageRows));
  private readonly later = button("Next", {}, () => this.turn(pageRows));
  private readonly pager = h("nav", { class: "actions pager", "aria-label": "Pages of comparisons" }, this.earlier, this.later);
  private drawn = ""; // what the table shows, to skip equal updates
  private searching: ReturnType<typeof setTimeout> | null = null;
  private again: ReturnType<typeof setTimeout> | null = null;
  private failed = false;
  private unannounced = false; // rows were requested and not announced yet

  constructor(
    private readonly source: RowSource,
    private readonly listState: ListState,
    private readonly remember: () => void,
    private readonly announcer: Announcer,
    private readonly signal: AbortSignal,
    private running: boolean,
  ) {
    const head = ["Comparison", "Verdict", "Distance", ""].map((title) => (title === "" ? h("td") : h("th", { scope: "col" }, title)));
    this.table = h("table", { class: "rows" }, h("caption", { class: "unseen" }, "Comparisons of the batch"), h("thead", {}, h("tr", {}, ...head)), this.body);
    this.body.addEventListener("click", (event) => this.open(event));
    this.search.value = listState.search;
    this.search.addEventListener("input", () => this.type());
    const field = h("div", { class: "field row-search" }, h("label", { for: "row-search" }, "Search by name"), this.search);
    const tiles = h("div", { class: "tiles", role: "group", "aria-label": "Which comparisons are shown" }, ...filters.map((filter) => this.tileOf(filter)));
    this.element = h("div", { class: "batch-list" }, stripStripes(), tiles, h("div", { class: "list-head" }, field, this.words), this.trouble, scroller("Comparisons", this.table), this.pager);
    signal.addEventListener("abort", () => this.stop(), { once: true });
  }

  private tileOf(filter: Filter): HTMLElement {
    const count = h("b", {}, "0");
    const kind = filter === "open" || filter === "all" ? "" : toneOf[filter];
    const tile = h("button", { type: "button", class: `tile ${kind}`, "aria-pressed": "false" }, count, h("span", {}, filterWords[filter]));
    tile.addEventListener("click", () => this.look({ filter, from: 0 }));
    this.tiles.set(filter, { tile, count });
    return tile;
  }

  /** Focuses the row that was opened, after going back; false: there is none. */
  focusOpened(): boolean {
    const link = this.listState.opened === null ? null : this.linkOf(String(this.listState.opened));
    link?.focus();
    return link !== null;
  }

  private linkOf(position: string): HTMLElement | null {
    return this.body.querySelector<HTMLElement>(`a[data-position="${position}"]`);
  }

  // Going back in the history leads here again.
  private open(event: Event): void {
    const link = event.target instanceof Element ? event.target.closest<HTMLElement>("a[data-position]") : null;
    if (!link) return;
    this.listState.opened = Number(link.dataset["position"]);
    this.remember();
  }

  /** Call when the source has more rows, or the counts have changed. */
  refresh(running: boolean): void {
    this.running = running;
    this.draw();
  }

  private get filter(): Filter {
    const { filter } = this.listState;
    if (filter !== null) return filter;
    return this.running || this.source.counts().open > 0 ? "open" : "all";
  }

  private type(): void {
    if (this.searching !== null) clearTimeout(this.searching);
    this.searching = setTimeout(() => this.look({ search: this.search.value, from: 0 }), searchPauseMs);
  }

  private turn(by: number): void {
    this.look({ from: Math.max(0, this.listState.from + by) });
    this.element.scrollIntoView({ block: "start" });
    const [pressed, other] = by > 0 ? [this.later, this.earlier] : [this.earlier, this.later];
    if (pressed.disabled) other.focus({ preventScroll: true });
  }

  private look(change: Partial<ListState>): void {
    Object.assign(this.listState, change);
    this.failed = false;
    this.remember();
    this.unannounced = true;
    this.draw();
  }

  private draw(): void {
    const { listState, source } = this;
    const counts = source.counts();
    for (const [filter, { tile, count }] of this.tiles) {
      count.textContent = grouped(counts[filter]);
      tile.setAttribute("aria-pressed", String(filter === this.filter));
      tile.classList.toggle("none", counts[filter] === 0);
      tile.hidden = counts[filter] === 0 && filter !== this.filter && !always.includes(filter);
    }
    let shown = source.shown(this.filter, listState.search, listState.from, pageRows);
    if (shown.complete && shown.rows.length === 0 && listState.from > 0) {
      listState.from = 0; // the list is shorter than before
      shown = source.shown(this.filter, listState.search, 0, pageRows);
    }
    const { rows, total, complete } = shown;
    const isReading = !complete && rows.length < (source.readSoFar === null ? 1 : pageRows);
    this.words.textContent = isReading ? this.readingWords() : this.wordsFor(rows.length, total);
    this.drawRows(rows);
    this.pager.hidden = total <= pageRows;
    this.earlier.disabled = listState.from === 0;
    this.later.disabled = listState.from + pageRows >= total;
    if (complete) this.trouble.replaceChildren();
    else if (!this.failed) void this.load();
    if (this.unannounced && !isReading) {
      this.unannounced = false;
      this.announcer.sayNow(`${filterWords[this.filter]}: ${this.words.textContent}`);
    }
  }

  private readingWords(): string {
    const { readSoFar } = this.source;
    return readSoFar === null ? "Reading the results …" : `Reading the results: ${grouped(readSoFar)} of ${grouped(this.source.counts().all)}`;
  }

  private wordsFor(shown: number, total: number): string {
    const { listState, source } = this;
    if (total > 0) return pageWords(listState.from, shown, total);
    if (listState.search.trim() !== "") return "No comparison with this name.";
    const { all, pass } = source.counts();
    if (this.filter === "open" && this.running) return "Everything that has ended so far has passed.";
    if (this.filter === "open" && all === pass) return "Everything has passed.";
    return this.running ? "None so far." : "None.";
  }

  private async load(): Promise<void> {
    if (this.again !== null) return;
    try {
      const wait = await this.source.load(this.signal);
      if (wait > 0 && !this.signal.aborted) this.again = setTimeout(() => ((this.again = null), this.draw()), wait);
    } catch (error) {
      if (this.signal.aborted || isAbort(error)) return;
      this.failed = true;
      const explained = explain(error);
      const retry = button("Try again", {}, () => ((this.failed = false), this.trouble.replaceChildren(), this.draw()));
      this.trouble.replaceChildren(h("div", { class: "notice busy" }, h("p", {}, `${explained.title}. ${explained.detail}`), retry));
    }
  }

  // The focused row keeps the focus, also when it moves.
  private drawRows(rows: readonly Row[]): void {
    const drawn = JSON.stringify(rows);
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    const focused = document.activeElement instanceof HTMLAnchorElement && this.body.contains(document.activeElement) ? document.activeElement.dataset["position"] : undefined;
    const scale = scaleFor(rows.flatMap(({ distance, limit }) => (distance ? [{ ...distance, limit }] : [])));
    this.body.replaceChildren(...rows.map((row) => rowElement(row, scale)));
    this.table.hidden = rows.length === 0;
    if (focused !== undefined) this.linkOf(focused)?.focus({ preventScroll: true });
  }

  private stop(): void {
    for (const timer of [this.searching, this.again]) if (timer !== null) clearTimeout(timer);
  }
}

function rowElement(row: Row, scale: StripScale | null): HTMLTableRowElement {
  const tone = toneOf[row.kind];
  const link = row.id === null ? row.name : h("a", { href: pathOf(row.id), "data-position": row.position }, row.name);
  const verdict = h("td", {}, h("span", { class: `mark ${tone}` }, iconOf(tone), filterWords[row.kind]));
  const name = h("th", { scope: "row" }, link);
  if (!row.distance) return h("tr", {}, name, verdict, h("td", { class: "row-words", colspan: 2 }, row.words));
  const { lower, upper } = row.distance;
  const limit = row.limits === "" ? null : h("small", {}, `limit ${row.limits}`);
  const picture = scale && strip(scale, { lower, upper, limit: row.limit });
  return h("tr", {}, name, verdict,
    h("td", { class: "row-distance" }, asSentence(intervalWords(lower, upper, row.units, row.limit)).replace(/\.$/, ""), " ", limit),
    h("td", { class: "row-strip" }, picture && h("span", { class: `plot strip ${tone}` }, picture)));
}
