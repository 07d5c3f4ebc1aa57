// A measurement from the files to the ended comparison: stores both meshes, starts it, watches it; and its view meanwhile:
// the uploads, the stage, the interval as it shrinks.
import type { Client } from "../api/client.js";
import { ProblemError } from "../api/problem.js";
import { hasEnded, type Job, type JobState, type ProgressEvent, type Side, type Stage } from "../api/types.js";
import { hex, store, type UploadStep } from "../api/upload.js";
import { watch } from "../api/watch.js";
import { button, h, type Announcer } from "../dom.js";
import type { Chosen, Order } from "../form/form.js";
import { History, TimelinePlot } from "../plot/timeline.js";
import { inBytes, intervalText, intervalWords, onClock, withUnits } from "../text/numbers.js";

/** Progress reports; times are the service's. */
export interface ProgressReporter {
  upload(side: Side, step: UploadStep): void;
  accepted(job: Job): void;
  progress(event: ProgressEvent): void;
  interrupted(): void;
}

export async function measure(client: Client, order: Order, report: ProgressReporter, signal: AbortSignal): Promise<Job> {
  const job = await begin(client, order, report, signal);
  report.accepted(job);
  return hasEnded(job) ? job : watch(client, job.id, report, signal);
}

async function begin(client: Client, order: Order, report: ProgressReporter, signal: AbortSignal): Promise<Job> {
  await client.read(order.options, signal); // before anything is sent
  const ids = await storeBoth(client, order, report, signal);
  const pair = { ...ids, options: order.options };
  try {
    return await client.begin(pair, newKey(), signal);
  } catch (error) {
    // The service had it a moment ago and has removed it since: send it again if the file is at hand.
    if (!(error instanceof ProblemError) || error.kind !== "unknown-mesh" || !haveFiles(order)) throw error;
    const again = await storeBoth(client, order, report, signal);
    return client.begin({ ...pair, ...again }, newKey(), signal);
  }
}

const haveFiles = (order: Order): boolean => order.a.kind === "file" && order.b.kind === "file";

// One after the other: two uploads share the connection's speed anyway, and the same file twice is sent once.
async function storeBoth(client: Client, order: Order, report: ProgressReporter, signal: AbortSignal): Promise<Record<Side, string>> {
  const a = await idOf(client, "a", order.a, report, signal);
  return { a, b: await idOf(client, "b", order.b, report, signal) };
}

// The service then sees one file and cannot say which of the two it is.
async function namingSide(side: Side, stored: Promise<string>): Promise<string> {
  try {
    return await stored;
  } catch (error) {
    const ofTheFile = error instanceof ProblemError && [413, 415, 422].includes(error.problem.status) && error.problem.errors.length === 0;
    if (ofTheFile) error.problem.errors.push({ part: side, where: "", message: error.problem.detail });
    throw error;
  }
}

async function idOf(client: Client, side: Side, chosen: Chosen, report: ProgressReporter, signal: AbortSignal): Promise<string> {
  if (chosen.kind === "file") return namingSide(side, store(client, chosen.file, (step) => report.upload(side, step), signal));
  report.upload(side, { step: "there", reused: true });
  return chosen.id;
}

// So that a repeated request starts nothing twice. crypto.randomUUID is missing on plain http.
const newKey = (): string => hex(crypto.getRandomValues(new Uint8Array(16)).buffer);

export function stageWords(state: JobState, stage: Stage): string {
  if (state === "queued") return "Waiting for a free worker";
  if (state !== "running") return "Ended";
  return stage === null ? "Reading both meshes" : running[stage];
}

const running: Record<NonNullable<Stage>, string> = {
  build: "Building a tree over each mesh",
  traverse: "Ruling out triangles that cannot matter",
  reduce: "Splitting the triangles that are left",
  certify: "Certifying the interval",
  areas: "Certifying shares of the area",
  statistics: "Sampling the surface",
};

export interface RunFace {
  names: Record<Side, string> | null; // null: the link has no names
  cancel(): void;
}

/** The view of one measurement; made anew for each, and ended by dispose(). */
export class RunView implements ProgressReporter {
  readonly history = new History();
  private readonly title = h("h1", { id: "run-title", tabindex: "-1" }, "Measuring");
  private readonly stage = h("p", { class: "stage-name" }, "Preparing");
  private readonly uploads: Record<Side, UploadRow>;
  private readonly reading = h("p", { class: "reading" });
  private readonly clock = h("span", { class: "clock" });
  private readonly note = h("p", { class: "hint" });
  private readonly cancelButton: HTMLButtonElement;
  private plot: TimelinePlot | null = null;
  private ticker: ReturnType<typeof setInterval> | null = null;
  private limit: number | null = null; // that of the accepted request
  private units = "";
  private latest: { event: ProgressEvent; at: number } | null = null;

  constructor(
    host: HTMLElement,
    private readonly face: RunFace,
    private readonly announcer: Announcer,
  ) {
    this.uploads = { a: new UploadRow("A", face.names?.a), b: new UploadRow("B", face.names?.b) };
    this.cancelButton = button("Cancel", { class: "cancel" }, () => this.cancel());
    const names = face.names ? h("p", { class: "lede" }, h("b", {}, face.names.a), " against ", h("b", {}, face.names.b)) : null;
    host.replaceChildren(
      this.title,
      ...(names ? [names, h("div", { class: "uploads" }, this.uploads.a.row, this.uploads.b.row)] : []),
      h("div", { class: "live" }, h("div", { class: "live-head" }, this.stage, this.clock), this.reading, this.plotHost, this.note),
      h("div", { class: "actions" }, this.cancelButton),
    );
  }

  private readonly plotHost = h("div", { class: "plot timeline", hidden: true });

  focus(): void {
    this.title.focus({ preventScroll: true });
  }

  upload(side: Side, step: UploadStep): void {
    this.uploads[side].show(step);
    this.stage.textContent = step.step === "hashing" ? "Looking whether the service has these files" : "Sending the meshes";
    this.announcer.say(this.stage.textContent);
  }

  accepted(job: Job): void {
    for (const side of ["a", "b"] as const) this.uploads[side].done();
    this.plotHost.hidden = false;
    const units = job.gate?.units ?? ""; // "b", "diagonal": not known before there is a result
    this.units = units === "b" || units === "diagonal" ? "" : units;
    this.limit = units === "diagonal" ? null : (job.gate?.max_distance ?? null);
    this.plot = new TimelinePlot(this.plotHost, { history: this.history, limit: this.limit, units: this.units, now: 0 });
    this.stage.textContent = stageWords(job.state, job.progress?.stage ?? null);
    this.reading.textContent = "Not known yet";
    this.ticker ??= setInterval(() => this.tick(), 200);
  }

  progress(event: ProgressEvent): void {
    const first = this.latest?.event;
    if (first?.state === "queued" && event.state !== "queued") this.latest = null; // the clock starts again when the work starts
    this.latest = { event, at: performance.now() };
    this.note.textContent = "";
    if (event.state !== "queued") this.remember(event);
    this.stage.textContent = stageWords(event.state, event.stage);
    this.showReading(event);
    this.announcer.say(`${this.stage.textContent}. ${intervalWords(event.lower, event.upper, this.units, this.limit)}`);
    this.tick();
  }

  interrupted(): void {
    this.note.textContent = "The connection broke. The comparison does not depend on it; asking again …";
  }

  /** Call when cancelling did not reach the service: it can be tried again. */
  mayCancel(): void {
    this.cancelButton.disabled = false;
    this.cancelButton.textContent = "Cancel";
  }

  dispose(): void {
    if (this.ticker !== null) clearInterval(this.ticker);
    this.plot?.dispose();
  }

  // At the start nothing was known, whether or not the page was watching.
  private remember(event: ProgressEvent): void {
    if (!this.history.last) this.history.add({ ms: 0, lower: 0, upper: null });
    this.history.add({ ms: event.elapsed_ms, lower: event.lower, upper: event.upper });
  }

  private showReading(event: ProgressEvent): void {
    const { limit, units } = this;
    const text = intervalText(event.lower, event.upper, limit);
    const nothing = event.upper === null && event.lower === 0;
    const upper = event.upper === null ? "not known" : withUnits(text.upper, units);
    const rows = nothing
      ? [h("span", { class: "quiet" }, "Not known yet")]
      : [h("span", {}, text.lower), h("span", { class: "dash" }, "to"), h("span", { class: event.upper === null ? "quiet" : "" }, upper)];
    this.reading.replaceChildren(...rows);
  }

  private tick(): void {
    if (!this.latest) return;
    const now = this.latest.event.elapsed_ms + performance.now() - this.latest.at;
    this.clock.textContent = onClock(now);
    this.plot?.show(this.latest.event.state === "queued" ? 0 : now);
  }

  private cancel(): void {
    this.cancelButton.disabled = true;
    this.cancelButton.textContent = "Cancelling …";
    this.face.cancel();
  }
}

class UploadRow {
  readonly row: HTMLElement;
  private readonly bar = h("progress", { max: 1, value: 0 });
  private readonly words = h("span", { class: "upload-words" }, "waits");

  constructor(letter: string, name: string | undefined) {
    this.bar.setAttribute("aria-label", `Upload of ${letter}`);
    this.row = h("div", { class: "upload" }, h("b", { class: "letter" }, letter), h("span", { class: "upload-name" }, name ?? ""), this.bar, this.words);
  }

  show(step: UploadStep): void {
    if (step.step === "hashing") {
      this.bar.removeAttribute("value");
      this.words.textContent = "hashing";
    } else if (step.step === "sending") {
      this.bar.value = step.of === 0 ? 0 : Math.min(step.sent / step.of, 1);
      this.words.textContent = `${inBytes(Math.min(step.sent, step.of))} of ${inBytes(step.of)}`;
    } else {
      this.bar.value = 1;
      this.words.textContent = step.reused ? "was there already" : "sent";
    }
  }

  done(): void {
    this.bar.value = 1;
  }
}
