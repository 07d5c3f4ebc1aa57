// A batch on the page, from its link to its end: loads, watches and cancels it; shows its progress, the outcomes of its
// comparisons, and downloads.
import { batchAt, cancelBatch, isAbort, reportOf, resultsOf, type Client, type Report } from "../api/client.js";
import { hasEnded, type Batch, type BatchCounts, type BatchProgressEvent } from "../api/types.js";
import { watchBatch, type Watcher } from "../api/watch.js";
import { button, card, h, svg, type Announcer } from "../dom.js";
import { iconOf } from "../result/icon.js";
import { downloadButton, linkRow } from "../result/share.js";
import { pathOf } from "../route.js";
import { BatchList, listStateOf, type ListState } from "./list.js";
import { kinds, RowSource, tally, type Kind } from "./rows.js";
import { lasting, nameOf, titleOf, toneOf, wordsOf } from "./words.js";

/** What the page around it does. */
export interface Around {
  host: HTMLElement;
  client: Client;
  announcer: Announcer;
  shown(): void; // show the host
  over(title: string, words: string): void; // replace the view: there is nothing to show
  trouble(error: unknown): void; // show an error beside the view
}

export class BatchDesk {
  private view: BatchView | null = null;
  private last: { id: string; source: RowSource } | null = null; // kept, so that going back does not read the rows again

  constructor(private readonly around: Around) {}

  /** Shows the batch until it has ended, or until the signal. `watching` is called when it runs and is visible. Throws as requests do. */
  async open(id: string, signal: AbortSignal, watching: () => void): Promise<void> {
    const { client, host, announcer } = this.around;
    const batch = await batchAt(client, id, signal);
    const listState = listStateOf(history.state);
    const source = this.last?.id === id ? this.last.source : null;
    const remember = () => history.replaceState({ listState } satisfies { listState: ListState }, "");
    this.around.shown();
    const view = new BatchView(host, { client, batch, source, listState, remember, cancel: () => void this.cancel(id, signal), signal }, announcer);
    this.view = view;
    this.last = { id, source: view.source };
    if (hasEnded(batch)) return;
    watching();
    view.end(await watchBatch(client, id, view, signal));
  }

  private async cancel(id: string, signal: AbortSignal): Promise<void> {
    try {
      const batch = await cancelBatch(this.around.client, id);
      if (!signal.aborted && hasEnded(batch)) this.view?.end(batch);
    } catch (error) {
      if (signal.aborted || isAbort(error)) return;
      this.around.trouble(error);
      this.view?.mayCancel();
    }
  }
}

interface BatchFace {
  client: Client;
  batch: Batch;
  source: RowSource | null; // of this batch, if it was shown before
  listState: ListState;
  remember(): void; // called when the list's state changes
  cancel(): void;
  signal: AbortSignal; // ends everything that the view does
}

const askEveryMs = 2000; // between two requests for new failures

/** The view of one batch; made anew each time that it is shown. */
class BatchView implements Watcher<BatchProgressEvent> {
  readonly source: RowSource;
  private readonly head = h("header", { class: "verdict" });
  private readonly title = h("h1", { tabindex: "-1" });
  private readonly reason = h("p", { class: "reason" });
  private readonly bar = h("div", { class: "batch-bar" });
  private readonly clock = h("p", { class: "hint batch-clock" });
  private readonly note = h("p", { class: "hint", role: "status" });
  private readonly cancelButton = button("Cancel", { class: "cancel" }, () => this.cancel());
  private readonly actions = h("div", { class: "actions" }, this.cancelButton);
  private readonly keep = h("div");
  private readonly list: BatchList;
  private readonly ticker: ReturnType<typeof setInterval>;
  private batch: Batch; // the newest document
  private now: BatchProgressEvent;
  private asking: ReturnType<typeof setTimeout> | null = null;

  constructor(
    host: HTMLElement,
    private readonly face: BatchFace,
    private readonly announcer: Announcer,
  ) {
    const { batch, client, signal } = face;
    this.batch = batch;
    this.now = batch;
    this.source = face.source ?? new RowSource(batch, (its) => resultsOf(client, batch.id, its));
    this.source.changed = () => this.list.refresh(this.runs());
    this.list = new BatchList(this.source, face.listState, () => face.remember(), announcer, signal, this.runs());
    const name = nameOf(batch);
    this.head.append(h("p", { class: "pair-names" }, name === null ? "Batch" : "Batch ", name === null ? null : h("b", {}, name)), this.title, this.reason, this.bar, this.clock, this.note, this.actions);
    host.replaceChildren(this.head, card("Comparisons", { class: "card" }, this.list.element), card("Keep it", { class: "card keep" }, this.keep));
    this.ticker = setInterval(() => this.tick(), 1000);
    signal.addEventListener("abort", () => this.dispose(), { once: true });
    this.take(batch);
    if (!this.list.focusOpened()) this.title.focus({ preventScroll: true });
  }

  progress(event: BatchProgressEvent): void {
    this.now = event;
    this.note.textContent = "";
    this.drawHead();
    if (this.isBehind()) this.ask();
    this.announcer.say(this.said());
  }

  interrupted(): void {
    this.note.textContent = "The connection broke. The batch does not depend on it; asking again …";
  }

  /** Call when the batch has ended. */
  end(batch: Batch): void {
    this.note.textContent = "";
    this.take(batch);
    this.announcer.sayNow(this.said());
  }

  /** Call when cancelling did not reach the service: it can be tried again. */
  mayCancel(): void {
    this.cancelButton.disabled = false;
    this.cancelButton.textContent = "Cancel";
  }

  private runs(): boolean {
    return !hasEnded(this.batch);
  }

  private said(): string {
    const { heading, reason } = wordsOf(this.now);
    return `${heading}. ${reason}`;
  }

  // Takes the batch's document.
  private take(batch: Batch): void {
    this.batch = batch;
    if (hasEnded(batch) || !this.isBehind()) this.now = batch; // an event may have been newer
    this.source.take(batch);
    this.drawHead();
    this.list.refresh(this.runs());
    this.drawKeep();
    this.tick();
  }

  private drawHead(): void {
    const words = wordsOf(this.now);
    this.head.className = `verdict batch ${words.tone}${this.runs() ? " running" : ""}`;
    this.title.replaceChildren(iconOf(words.tone), words.heading);
    this.reason.textContent = words.reason;
    this.bar.replaceChildren(stackedBar(this.now));
    this.actions.hidden = !this.runs();
    document.title = titleOf(nameOf(this.batch), this.now);
  }

  private tick(): void {
    const { created, finished } = this.batch;
    const took = (finished === null ? Date.now() : Date.parse(finished)) - Date.parse(created);
    this.clock.textContent = `Began ${new Date(created).toLocaleString()}, ${finished === null ? "running for" : "took"} ${lasting(took)}`;
    if (finished !== null) clearInterval(this.ticker);
  }

  // True if more comparisons have ended than the document has.
  private isBehind(): boolean {
    return tally(this.batch.counts).all < tally(this.now.counts).all;
  }

  // Events have counts only; the failures are requested, at intervals.
  private ask(): void {
    this.asking ??= setTimeout(() => void this.askNow(), askEveryMs);
  }

  private async askNow(): Promise<void> {
    const { client, signal } = this.face;
    try {
      const batch = await batchAt(client, this.batch.id, signal);
      if (!signal.aborted && this.runs() && !hasEnded(batch)) this.take(batch); // the watcher reports the end
    } catch (error) {
      if (signal.aborted || isAbort(error)) return;
      this.interrupted();
    } finally {
      this.asking = null;
      if (!signal.aborted && this.runs() && this.isBehind()) this.ask();
    }
  }

  private drawKeep(): void {
    if (this.keep.childElementCount > 0 && this.runs()) return;
    const { id, expires } = this.batch;
    const note = h("p", { class: "hint", role: "status" }, this.runs() ? "The JUnit report comes when all have ended." : "");
    const junit = this.download("JUnit report", "junit.xml", note);
    junit.disabled = this.runs();
    this.keep.replaceChildren(
      linkRow(pathOf(id, "batch"), expires, "batch"),
      h("div", { class: "actions" }, junit, this.download("Results as JSON lines", "results.jsonl", note)),
      note,
    );
  }

  private download(label: string, report: Report, note: HTMLElement): HTMLButtonElement {
    const { client, signal } = this.face;
    return downloadButton(label, {}, {
      name: `batch-${this.batch.id.slice(0, 8)}${report === "junit.xml" ? "-junit.xml" : ".jsonl"}`,
      doing: "Loading …",
      note,
      ask: () => reportOf(client, this.batch.id, report, signal),
    });
  }

  private cancel(): void {
    this.title.focus({ preventScroll: true }); // the focused button is about to be removed
    this.cancelButton.disabled = true;
    this.cancelButton.textContent = "Cancelling …";
    this.face.cancel();
  }

  private dispose(): void {
    clearInterval(this.ticker);
    if (this.asking !== null) clearTimeout(this.asking);
  }
}

export interface BarPart {
  kind: Kind | "runs" | "waits";
  x: number;
  width: number;
}

const barLength = 1000; // in units of the picture
const leastPart = 4; // so that one of 10,000 is visible

/** The segments that are not empty, side by side from 0 to 1000. */
export function partsOf(counts: BatchCounts): BarPart[] {
  const so = tally(counts);
  const all: [BarPart["kind"], number][] = [...kinds.map((kind): [Kind, number] => [kind, so[kind]]), ["runs", counts.running], ["waits", counts.queued]];
  const there = all.filter(([, count]) => count > 0);
  const shared = barLength - leastPart * there.length;
  let x = 0;
  return there.map(([kind, count]) => {
    const part = { kind, x, width: leastPart + (count / counts.total) * shared };
    x += part.width;
    return part;
  });
}

// All comparisons of a batch as one bar: their outcomes, those running and those waiting.
function stackedBar(now: BatchProgressEvent): SVGSVGElement {
  const { heading, reason } = wordsOf(now);
  const picture = svg("svg", { viewBox: `0 0 ${String(barLength)} 20`, preserveAspectRatio: "none", role: "img", "aria-label": `${heading}. ${reason}` });
  for (const { kind, x, width } of partsOf(now.counts)) picture.append(svg("rect", { x, width, height: 20, class: classOf(kind) }));
  return picture;
}

function classOf(kind: BarPart["kind"]): string {
  return kind === "runs" || kind === "waits" ? `part ${kind}` : `part ${toneOf[kind]} ${kind}`;
}
