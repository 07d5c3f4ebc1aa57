// The deviation maps of a comparison, for the viewer and as files.
import type { Client } from "../api/client.js";
import type { Comparison, Side } from "../api/types.js";
import { button, h } from "../dom.js";
import { inBytes } from "../text/numbers.js";
import { asSentence, explain } from "../text/problems.js";
import { criteriaOf, foremostOf, isLimit, witnessesOf, witnessesToShow } from "../text/criteria.js";
import { unitsOf } from "../text/verdict.js";
import type { ViewerInput } from "../viewer/mount.js";
import { downloadButton } from "./share.js";

const shownTriangles = 200_000; // more makes the picture slower, and no clearer

const forms = ["ply", "glb", "vtp", "csv"] as const;
type Form = (typeof forms)[number];

function pathOfMap(id: string, form: Form, of: Side, mostTriangles?: number): string {
  const query = new URLSearchParams({ of, ...(mostTriangles === undefined ? {} : { max_triangles: String(mostTriangles) }) });
  return `/v1/comparisons/${id}/deviation.${form}?${query.toString()}`;
}

/** Reads the bytes of a response, reporting progress. */
async function bytesOf(answer: Response, report: (bytes: number, of: number | null) => void): Promise<ArrayBuffer> {
  if (!answer.body) return answer.arrayBuffer();
  const of = Number(answer.headers.get("Content-Length") ?? NaN);
  const reader = answer.body.getReader();
  const pieces: Uint8Array<ArrayBuffer>[] = [];
  for (let got = 0; ; ) {
    const { done, value } = await reader.read();
    if (done) return new Blob(pieces).arrayBuffer();
    pieces.push(value);
    got += value.length;
    report(got, Number.isFinite(of) ? of : null);
  }
}

// The limit of the point that is shown first, which may be a region's.
function limitOf(result: Comparison): number | null {
  const first = foremostOf(result);
  return first && isLimit(first) && first.of === "distance" && !first.side ? first.limit : (result.gate?.max_distance ?? null);
}

function sideLimitsOf(result: Comparison): ViewerInput["sideLimits"] {
  const limits = criteriaOf(result).filter(isLimit);
  const [inside, outside] = (["inside", "outside"] as const).map((side) => limits.find((one) => one.side === side));
  return inside && outside && { inside, outside };
}

/** Loads both maps and the viewer into `host`; if that fails, shows the reason there. */
export async function showViewer(host: HTMLElement, client: Client, result: Comparison, signal: AbortSignal): Promise<() => void> {
  const words = h("p", { class: "loading", role: "status" }, "Computing where the surfaces differ …");
  const bar = h("progress", { "aria-label": "Loading the deviation maps" });
  host.replaceChildren(h("div", { class: "viewer-wait" }, words, bar));
  try {
    const load = async (of: Side): Promise<ArrayBuffer> => {
      const path = pathOfMap(result.id, "glb", of, shownTriangles);
      const answer = await client.sendWithRetries(path, { signal, doing: "loading the deviation maps" });
      return bytesOf(answer, (got) => (words.textContent = `Loading the surface of ${of.toUpperCase()}: ${inBytes(got)}`));
    };
    const modules = Promise.all([import("../viewer/map.js"), import("../viewer/mount.js")]);
    modules.catch(() => undefined); // awaited below; a refused map is reported first
    const a = await load("a");
    const b = await load("b");
    const [{ parseMap }, { mountViewer }] = await modules;
    const maps = { a: await parseMap(a), b: await parseMap(b) };
    if (signal.aborted) return () => undefined;
    host.replaceChildren();
    const viewer = mountViewer(host, {
      ...maps,
      ...(result.direction === "symmetric" ? {} : { measured: [result.direction === "a_to_b" ? "a" : "b"] as Side[] }),
      limit: limitOf(result),
      sideLimits: sideLimitsOf(result),
      units: unitsOf(result),
      witnesses: witnessesToShow(result),
    });
    return () => viewer.dispose();
  } catch (error) {
    let end: () => void = () => undefined;
    const again = () => void showViewer(host, client, result, signal).then((next) => (end = next));
    if (!signal.aborted) host.replaceChildren(refusal(error, again));
    return () => end();
  }
}

function refusal(error: unknown, again: () => void): HTMLElement {
  const explained = explain(error);
  return h(
    "div",
    { class: "viewer-wait", role: "status" },
    h("p", {}, h("b", {}, "The surfaces cannot be shown. "), asSentence(explained.detail || explained.defects[0]?.message || explained.title)),
    h("p", { class: "hint" }, "All else on this page holds."),
    explained.retry ? button("Try again", {}, again) : null,
  );
}

/** Buttons that save the map of each mesh; a refusal is shown in `note`. What one mesh lacks is visible only on the other one. */
export function mapRows(client: Client, result: Comparison, note: HTMLElement): HTMLElement[] {
  const [witness] = witnessesOf(result);
  return (["a", "b"] as const).map((of) => {
    const [one, other] = of === "a" ? ["A", "B"] : ["B", "A"];
    const found = witness?.from === of && witness.lower > 0 ? ". The point that attains the lower end lies on it" : "";
    const words = `Deviation map: ${one} coloured by its distance to ${other}${found}.`;
    return h("div", { class: "actions map" }, ...forms.map((form) => mapButton(client, result, of, form, note)), h("p", { class: "hint" }, words));
  });
}

function mapButton(client: Client, result: Comparison, of: Side, form: Form, note: HTMLElement): HTMLButtonElement {
  const label = `${of.toUpperCase()} as ${form.toUpperCase()}`;
  return downloadButton(label, { "aria-label": `Deviation map of ${label}` }, {
    name: `deviation-${of}-${result.id.slice(0, 8)}.${form}`,
    doing: "Computing the map …",
    note,
    ask: () => client.sendWithRetries(pathOfMap(result.id, form, of), { doing: "loading the deviation map" }),
  });
}
