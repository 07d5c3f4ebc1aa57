// A running comparison: the uploads, the stage, the interval as it shrinks.
import type { Job, ProgressEvent, Side } from "../api/types.js";
import type { UploadStep } from "../api/upload.js";
import { button, h, type Announcer } from "../dom.js";
import { History } from "../plot/history.js";
import { TimelinePlot } from "../plot/timeline.js";
import { inBytes, intervalText, intervalWords, onClock, withUnits } from "../text/numbers.js";
import { stageWords } from "../text/stages.js";
import type { ProgressReporter } from "./run.js";

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
