// The tables of a result: what has a verdict of its own, a row each; without limits, what was measured of each region; and
// the facts about both meshes side by side.
import type { Comparison, MeshFacts, Side } from "../api/types.js";
import { h, scroller, tableCard } from "../dom.js";
import { criteriaOf, isLimit, plusMinus, rest, type Criterion } from "../text/criteria.js";
import { withoutOverrides } from "../text/names.js";
import {
  grouped, inBytes, inPercentAbove, intervalText, intervalWords, plain, pointText, toDigits, toDigitsBelow, withUnits,
} from "../text/numbers.js";
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

type Region = NonNullable<Comparison["regions"]>[number];

const regionName = ({ name }: Pick<Region, "name">): string => (name === rest ? "The rest" : withoutOverrides(name));

/** Where a region lies, in the numbers of the request, or its group's name; "": the rest. */
export function placeOf({ box, sphere, group }: Pick<Region, "box" | "sphere" | "group">): string {
  return box || sphere ? JSON.stringify(box ?? sphere) : withoutOverrides(group ?? "");
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
  const more = plusMinus(criterion, unitsOf(result));
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

type Row = [string, (mesh: MeshFacts, units: string) => string];

const factRows: Row[] = [
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
  const body: HTMLElement[] = factRows.flatMap(([label, text]) => {
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
