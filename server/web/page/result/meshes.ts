// Facts about both meshes side by side.
import type { Comparison, MeshFacts, Side } from "../api/types.js";
import { h, scroller } from "../dom.js";
import { unitsOf } from "../text/verdict.js";
import { grouped, inBytes, pointText, toDigits, withUnits } from "../text/numbers.js";

type Row = [string, (mesh: MeshFacts, units: string) => string];

const rows: Row[] = [
  ["Format", (mesh) => formatWords(mesh)],
  ["Unit", (mesh) => unitWords(mesh)],
  ["Size", (mesh) => inBytes(mesh.bytes) + (mesh.gzip ? ", gzip-compressed" : "")],
  ["Triangles", (mesh) => (mesh.triangles === 0 ? "none, a point cloud" : grouped(mesh.triangles))],
  ["Vertices", (mesh) => grouped(mesh.vertices)],
  ["Without area", (mesh) => (mesh.degenerate === 0 ? "" : grouped(mesh.degenerate))],
  ["Box from", (mesh) => pointText(mesh.bbox.low)],
  ["Box to", (mesh) => pointText(mesh.bbox.high)],
  ["Diagonal", (mesh) => toDigits(mesh.diagonal, 7)],
  ["Watertight", ({ topology }) => (topology ? edgeWords(topology.watertight, [topology.open_edges, "open"], [topology.non_manifold_edges, "of three or more triangles"]) : "")],
  ["Oriented", ({ topology }) => (topology ? edgeWords(topology.oriented, [topology.flipped_edges, "passed twice in one direction"]) : "")],
  ["Components", ({ topology }) => (topology ? grouped(topology.components) : "")],
  ["Volume", ({ topology }, units) => (topology?.volume ? volumeWords(topology.volume, units) : "")],
];

type EdgeKind = [NonNullable<MeshFacts["topology"]>["open_edges"], string];

/** "no: 4 edges open, the first at (0.5, 0, 1)" */
function edgeWords(holds: boolean, ...kinds: EdgeKind[]): string {
  const found = kinds.filter(([{ count }]) => count > 0);
  const said = found.map(([{ count, first }, kind]) => `${grouped(count)} ${count === 1 ? "edge" : "edges"} ${kind}${first ? `, the first at ${pointText(first)}` : ""}`);
  return (holds ? "yes" : "no") + (said.length ? `: ${said.join("; ")}` : "");
}

function volumeWords({ lower, upper }: { lower: number | null; upper: number | null }, units: string): string {
  if (lower === null || upper === null) return "beyond the range of numbers";
  return withUnits(toDigits(lower / 2 + upper / 2, 7), units && `${units}³`);
}

const formatWords = (mesh: MeshFacts): string => mesh.format.toUpperCase().replace("GLTF", "glTF");

const sources = { file: "its file says so", declared: "declared", assumed: "taken from the limit", unknown: "" };

// Results made before 0.2.0 have none.
function unitWords({ unit }: { unit?: MeshFacts["unit"] }): string {
  return !unit || unit.name === null ? "not known" : `${unit.name}, ${sources[unit.source]}`;
}

export function meshesTable(result: Comparison, names: Record<Side, string>): HTMLElement {
  const { a, b } = result.meshes, units = unitsOf(result);
  const body: HTMLElement[] = rows.flatMap(([label, text]) => {
    const [one, other] = [text(a, units), text(b, units)];
    if (one === "" && other === "") return [];
    return [h("tr", {}, h("th", { scope: "row" }, label), h("td", {}, one || "none"), h("td", {}, other || "none"))];
  });
  body.push(h("tr", {}, h("th", { scope: "row" }, "SHA-256"), h("td", {}, hash(a)), h("td", {}, hash(b))));
  body.push(...notes(a, b));
  const head = h("tr", {}, h("td"), column("A", names.a), column("B", names.b));
  return scroller("Facts about both meshes", h("table", { class: "meshes" }, h("caption", { class: "unseen" }, "Facts about both meshes"), h("thead", {}, head), h("tbody", {}, ...body)));
}

function column(letter: string, name: string): HTMLElement {
  return h("th", { scope: "col" }, h("b", { class: "letter" }, letter), " ", name);
}

const hash = (mesh: MeshFacts): HTMLElement => h("code", { class: "hash" }, mesh.sha256);

function notes(a: MeshFacts, b: MeshFacts): HTMLElement[] {
  if (a.notes.length === 0 && b.notes.length === 0) return [];
  const list = (texts: string[]) => (texts.length === 0 ? "none" : h("ul", {}, ...texts.map((text) => h("li", {}, text))));
  return [h("tr", {}, h("th", { scope: "row" }, "Notes"), h("td", {}, list(a.notes)), h("td", {}, list(b.notes)))];
}
