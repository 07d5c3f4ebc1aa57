// Creates elements. All text from the service or from files enters the page here, as text.

type Child = Node | string | null | undefined | false;
export type Attributes = Record<string, string | number | boolean | null | undefined>;

/** Returns an element. Attributes that are false or null are left out; true sets one without a value. */
export function h<K extends keyof HTMLElementTagNameMap>(tag: K, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  fill(element, attributes, children);
  return element;
}

export function svg<K extends keyof SVGElementTagNameMap>(tag: K, attributes: Attributes = {}, ...children: Child[]): SVGElementTagNameMap[K] {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  fill(element, attributes, children);
  return element;
}

function fill(element: Element, attributes: Attributes, children: Child[]): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children.filter((child): child is Node | string => child !== null && child !== undefined && child !== false));
}

/** Returns an element that the page's own markup must have. */
export function find<T extends Element>(selector: string, kind: new () => T, within: ParentNode = document): T {
  const found = within.querySelector(selector);
  if (!(found instanceof kind)) throw new Error(`the page has no ${selector}`);
  return found;
}

export function button(label: string, attributes: Attributes, press: () => void): HTMLButtonElement {
  const element = h("button", { type: "button", ...attributes }, label);
  element.addEventListener("click", press);
  return element;
}

/** Says at a field what is wrong with it; "": nothing is. */
export function complainAt(field: Element, error: HTMLElement, message: string): void {
  error.textContent = message;
  error.hidden = message === "";
  field.setAttribute("aria-invalid", String(message !== ""));
}

/** Returns a list of terms; rows without a value are left out. */
export function facts(rows: [string, Child | Child[]][]): HTMLDListElement {
  const list = h("dl", { class: "facts" });
  for (const [term, value] of rows) {
    if (value === null || value === undefined || value === false || value === "") continue;
    list.append(h("div", {}, h("dt", {}, term), h("dd", {}, ...(Array.isArray(value) ? value : [value]))));
  }
  return list;
}

/** Returns a part of the result with its heading. */
export function card(title: string, attributes: Attributes, ...children: Child[]): HTMLElement {
  const id = `h-${title.toLowerCase().replace(/[^a-z]+/g, "-")}`;
  return h("section", { ...attributes, "aria-labelledby": id }, h("h2", { id }, title), ...children);
}

/** Returns a part of the result that is a table; the first cell of a row is its head. */
export function tableCard(title: string, columns: string[], rows: Child[][], kind = ""): HTMLElement {
  const head = h("tr", {}, ...columns.map((name) => h("th", { scope: "col" }, name)));
  const body = rows.map(([first, ...cells]) => h("tr", {}, h("th", { scope: "row" }, first), ...cells.map((cell, i) => h("td", { "data-name": columns[i + 1] ?? "" }, cell))));
  return card(title, { class: "card" }, scroller(title, h("table", kind ? { class: kind } : {}, h("thead", {}, head), h("tbody", {}, ...body))));
}

/** Wraps content that may be wider than its place. While it is, the keyboard can scroll it; `label` names it. */
export function scroller(label: string, child: HTMLElement): HTMLElement {
  const box = h("div", { class: "scroll" }, child);
  const adapt = () => {
    const scrolls = box.scrollWidth > box.clientWidth;
    for (const [name, value] of Object.entries({ tabindex: "0", role: "region", "aria-label": label })) {
      if (scrolls) box.setAttribute(name, value);
      else box.removeAttribute(name);
    }
  };
  const watcher = new ResizeObserver(adapt);
  watcher.observe(box);
  watcher.observe(child);
  return box;
}

const leastGapMs = 8000;

/** A live region that announces the newest sentence only, and no more often than it can be read out. */
export class Announcer {
  private timer: ReturnType<typeof setTimeout> | null = null;
  private pending = "";
  private last = 0;

  constructor(private readonly region: HTMLElement) {}

  say(text: string, now = performance.now()): void {
    this.pending = text;
    if (this.timer !== null) return;
    this.timer = setTimeout(() => this.announce(), Math.max(0, this.last + leastGapMs - now));
  }

  /** Announces at once, for ends of the work. */
  sayNow(text: string): void {
    this.pending = text;
    this.announce();
  }

  private announce(): void {
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = null;
    this.last = performance.now();
    this.region.textContent = this.pending;
  }
}
