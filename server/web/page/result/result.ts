// The page of a comparison that ended with an interval.
import type { Client } from "../api/client.js";
import type { Comparison, Job, Side } from "../api/types.js";
import { button, card, facts, h } from "../dom.js";
import { pathOf } from "../route.js";
import { gaugeIn } from "../plot/gauge.js";
import { TimelinePlot, type History } from "../plot/timeline.js";
import { capital, withoutOverrides } from "../text/names.js";
import { inPercent, inPercentAbove, inTime, intervalText, intervalWords, plain, toDigits, withUnits } from "../text/numbers.js";
import { pairNotes, rangeOf, statusSentence, unitOf, unitsOf, wordingOf } from "../text/verdict.js";
import { criteriaOf, foremostOf, isLimit, shownLimit, type Limit } from "../text/criteria.js";
import { directionsOf } from "./directions.js";
import { iconOf } from "./icon.js";
import { mapRows, showViewer } from "./maps.js";
import { jsonButton, linkRow, pipeline } from "./share.js";
import { criteriaTable, meshesTable, regionsOf } from "./tables.js";
import { timesOf } from "./times.js";

export interface ResultFace {
  job: Job;
  result: Comparison;
  names: Record<Side, string>;
  history: History | null; // null: the page did not watch it
  timeoutMs: number | null; // null: unknown
  again(): void;
  narrow(): void;
}

const leastHistoryMs = 300; // a shorter comparison has nothing to show over time

/** Fills `host`; returns a function that ends what it started. */
export function showResult(host: HTMLElement, client: Client, face: ResultFace): () => void {
  const { job, result, names } = face;
  const ends: (() => void)[] = [];
  const stage = h("div", { class: "viewer-host" });
  host.replaceChildren(
    verdictOf(face, ends),
    criteriaTable(result) ?? "",
    regionsOf(result) ?? "",
    card("Where they differ", { class: "card wide" }, stage),
    columns(face, ends),
    card("The meshes", { class: "card" }, meshesTable(result, names)),
    card("Put it into a pipeline", { class: "card" }, pipeline(result, names, client.key !== "")),
    card("Keep it", { class: "card keep" }, linkRow(pathOf(job.id), job.expires), downloads(client, result)),
  );
  const controller = new AbortController();
  ends.push(() => controller.abort());
  void showViewer(stage, client, result, controller.signal).then((end) => ends.push(end));
  return () => ends.forEach((end) => end());
}

function verdictOf(face: ResultFace, ends: (() => void)[]): HTMLElement {
  const { result, names } = face;
  const words = wordingOf(result, face.timeoutMs);
  return h(
    "header",
    { class: `verdict ${words.tone}` },
    h("p", { class: "pair-names" }, h("b", {}, names.a), " against ", h("b", {}, names.b)),
    h("h1", { tabindex: "-1" }, iconOf(words.tone), words.heading),
    words.tone === "measured" ? null : readingOf(result),
    h("p", { class: "reason" }, words.reason),
    words.proof === "" ? null : h("p", { class: "proof" }, words.proof),
    ...pairNotes(result).map((note) => h("p", { class: "note" }, `Note: ${note}.`)),
    ...gaugesOf(result, ends),
    h("div", { class: "actions" }, narrower(face), button("Measure again", { class: "again" }, () => face.again()), h("a", { class: "button", href: "/" }, "New pair")),
  );
}

// The work stops when the limit is decided; this measures the distance itself.
function narrower(face: ResultFace): HTMLElement | null {
  const { lower, upper } = face.result.distance;
  if (face.result.status !== "gate_decided" || upper === lower) return null;
  return button("Narrow the interval", { title: "Measure the distance itself, without the limit" }, () => face.narrow());
}

// The foremost limit; where an expectation is foremost, the whole distance.
function readingOf(result: Comparison): HTMLElement {
  const first = foremostOf(result), limit = first && isLimit(first) && !first.refused ? first : null;
  if (limit?.of === "share") return h("p", { class: "reading" }, h("span", {}, rangeOf(limit, result)));
  const { lower, upper } = limit ?? result.distance;
  const text = intervalText(lower, upper, limit && shownLimit(limit));
  const top = withUnits(text.upper, upper === null ? "" : unitsOf(result));
  const range = text.lower === text.upper ? [h("span", {}, top)] : [h("span", {}, text.lower), h("span", { class: "dash" }, "to"), h("span", {}, top)];
  return h("p", { class: "reading" }, ...range);
}

// One for the foremost distance; where that is of a side, one for each side.
function gaugesOf(result: Comparison, ends: (() => void)[]): HTMLElement[] {
  const distances = criteriaOf(result).filter((one): one is Limit => isLimit(one) && one.of === "distance" && !one.refused);
  const first = distances.find(({ name }) => name === foremostOf(result)?.name) ?? distances[0];
  const shown = first?.side ? distances.filter(({ side }) => side) : [first ?? null];
  return shown.flatMap((one) => {
    const host = h("div", { class: `plot gauge ${one?.verdict ?? ""}` });
    const { lower, upper } = one ?? result.distance;
    const name = one && one.name !== "distance" ? withoutOverrides(capital(one.name)) : "";
    const gauge = gaugeIn(host, { lower, upper, limit: one?.limit ?? null, units: unitsOf(result), name });
    ends.push(() => gauge.dispose());
    return name === "" ? [host] : [h("p", { class: "gauge-name" }, name), host];
  });
}

function columns(face: ResultFace, ends: (() => void)[]): HTMLElement {
  const { result, history } = face;
  const seen = history && (history.last?.ms ?? 0) >= leastHistoryMs ? shrinking(face, history, ends) : null;
  return h(
    "div",
    { class: "cards" },
    h("div", {}, card("Both directions", { class: "card" }, directionsOf(result)), seen),
    h(
      "div",
      {},
      card("Precision", { class: "card" }, precision(result)),
      card("Time", { class: "card" }, ...timesOf(result.timings_ms), engine(result)),
    ),
  );
}

function shrinking(face: ResultFace, history: History, ends: (() => void)[]): HTMLElement {
  const { result } = face;
  const host = h("div", { class: "plot timeline" });
  const limit = result.gate?.max_distance ?? null;
  const now = Math.max(history.last?.ms ?? 0, 1);
  const plot = new TimelinePlot(host, { history, limit, units: unitsOf(result), now });
  ends.push(() => plot.dispose());
  return card("How the interval shrank", { class: "card" }, host);
}

function precision(result: Comparison): HTMLElement {
  const { reached, asked } = result.tolerance;
  const units = unitsOf(result);
  const { upper } = result.distance;
  return h(
    "div",
    {},
    h("p", {}, statusSentence(result)),
    facts([
      ["Interval", intervalWords(result.distance.lower, upper, units, result.gate?.max_distance ?? null)],
      ["In full", `${plain(result.distance.lower)} … ${plain(upper ?? Infinity)}`],
      ["Its width", widthWords(reached, units)],
      ["Asked for", askedWords(asked, units)],
      ["Rounding alone", `${withUnits(toDigits(result.precision_floor, 2), units)} of the width`],
      ["Against the size", sizeWords(upper, result)],
    ]),
  );
}

// A baseline that is a point has no size; a converted one has its size in another unit.
function sizeWords(upper: number | null, result: Comparison): string {
  const { diagonal } = result.meshes.b;
  const unit = unitOf(result);
  if (unit !== null && unit !== unitOf(result.meshes.b)) return "";
  return upper === null || diagonal === 0 ? "" : `The distance is at most ${inPercentAbove(upper / diagonal, 3)} of B's diagonal`;
}

function widthWords(reached: Comparison["tolerance"]["reached"], units: string): string {
  const { absolute, relative, diagonal } = reached;
  if (absolute === null) return "not known";
  const shares = [relative === null || relative > 1 ? "" : `${inPercent(relative, 2)} of the distance`, diagonal === null ? "" : `${inPercent(diagonal, 2)} of A's diagonal`];
  return [withUnits(toDigits(absolute, 3), units), ...shares.filter((share) => share !== "")].join(", ");
}

function askedWords(asked: Comparison["tolerance"]["asked"], units: string): string {
  const parts: string[] = [];
  if (asked.absolute !== undefined) parts.push(withUnits(plain(asked.absolute), units));
  if (asked.relative !== undefined) parts.push(`${inPercent(asked.relative)} of the distance`);
  if (asked.diagonal !== undefined) parts.push(`${asked.diagonal < 1e-4 ? plain(asked.diagonal) : inPercent(asked.diagonal)} of A's diagonal`);
  return parts.join(", or ");
}

function engine(result: Comparison): HTMLElement {
  const { version, strategy, points, simd, threads } = result.engine;
  const how = `${strategy}${points === null ? "" : ` with ${String(points)} points`}, ${simd}, ${String(threads)} ${threads === 1 ? "thread" : "threads"}`;
  return h("p", { class: "hint" }, `meshgauge ${version}: ${how}; ${inTime(result.timings_ms.total)} in all.`);
}

function downloads(client: Client, result: Comparison): HTMLElement {
  const note = h("p", { class: "hint", role: "status" });
  return h("div", {}, h("div", { class: "actions" }, jsonButton(result)), ...mapRows(client, result, note), note);
}
