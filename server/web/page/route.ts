// The addresses of the page: what each shows, and what is said of a damaged link.

export type Linked = "comparison" | "batch";

export type Route =
  | { view: "form" }
  | { view: "comparison"; id: string }
  | { view: "batch"; id: string }
  | { view: "damaged"; of: Linked; id: string } // a link with a malformed id
  | { view: "unknown"; path: string };

const folders: Record<string, Linked> = { c: "comparison", b: "batch" };

export function routeOf(path: string): Route {
  if (path === "/" || path === "") return { view: "form" };
  const [, folder = "", id = ""] = /^\/([bc])(?:\/([^/]*))?\/?$/.exec(path) ?? [];
  const of = folders[folder];
  if (of === undefined) return { view: "unknown", path };
  return /^[0-9a-f]{32}$/.test(id) ? { view: of, id } : { view: "damaged", of, id };
}

export function pathOf(id: string, of: Linked = "comparison"): string {
  return `/${of === "batch" ? "b" : "c"}/${id}`;
}

/** Finds the id in a damaged link, where text was added or letters were made upper case; null: there is none. */
export function idWithin(damaged: string): string | null {
  const found = damaged.toLowerCase().match(/[0-9a-f]+/g)?.filter((one) => one.length >= 32) ?? [];
  return found.length === 1 && found[0]?.length === 32 ? found[0] : null;
}

/** Explains a damaged link. */
export function damagedWords(of: Linked, id: string): string {
  const digits = id.toLowerCase().replace(/[^0-9a-f]/g, "").length;
  const whole = `A link to a ${of} ends in 32 characters, each a digit or a letter from a to f.`;
  if (digits === id.length && digits < 32) return `${whole} This one has ${String(digits)}: the rest was cut off on its way here. Copy all of it once more.`;
  return `${whole} This one ends in something else: copy it once more.`;
}
