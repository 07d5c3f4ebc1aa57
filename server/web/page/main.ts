// The entry point: the page's views and the transitions between them. The address decides which one is shown.
import { Client, isAbort } from "./api/client.js";
import { ProblemError } from "./api/problem.js";
import { hasEnded, type Comparison, type Job, type Side } from "./api/types.js";
import { watch } from "./api/watch.js";
import { BatchDesk } from "./batch/batch.js";
import { Announcer, find, h } from "./dom.js";
import { acceptDrops, Form, type Chosen, type Order } from "./form/form.js";
import type { Json } from "./form/options.js";
import { nameOf } from "./form/slot.js";
import { KeyDialog } from "./key.js";
import { showResult } from "./result/result.js";
import { fallbackNames } from "./result/share.js";
import { damagedWords, idWithin, pathOf, routeOf, type Linked } from "./route.js";
import { measure, RunView } from "./run/run.js";
import { optionsOf, withoutLimits } from "./text/snippets.js";
import { titleOf, wordingOf } from "./text/verdict.js";
import { showTrouble } from "./trouble.js";

type View = "form" | "run" | "result" | "batch" | "none";

/** What is known of a measurement that this page started; a link alone has none of it. */
interface Memory {
  names: Record<Side, string>;
  order: Order;
}

class App {
  private readonly views = {
    form: find("#form-view", HTMLElement),
    run: find("#run-view", HTMLElement),
    result: find("#result-view", HTMLElement),
    batch: find("#batch-view", HTMLElement),
  };
  private readonly trouble = find("#trouble", HTMLElement);
  private readonly waiting = find("#waiting", HTMLElement);
  private readonly announcer = new Announcer(find("#status", HTMLElement));
  private readonly keys: KeyDialog = new KeyDialog(() => this.client);
  private readonly client: Client = new Client((wait) => this.showWait(wait), () => this.keys.ask());
  private readonly form = new Form((order) => void this.begin(order));
  private readonly memories = new Map<string, Memory>();
  private readonly batches = new BatchDesk({
    host: this.views.batch,
    client: this.client,
    announcer: this.announcer,
    shown: () => this.show("batch", "Batch · meshgauge"),
    over: (title, words) => this.over(title, words),
    trouble: (error) => void showTrouble(this.trouble, error, {}),
  });
  private controller = new AbortController();
  private run: RunView | null = null;
  private running: string | null = null; // the comparison being watched; the address may still name another one
  private endResult: () => void = () => undefined;

  start(): void {
    this.keys.refresh();
    acceptDrops((files) => this.form.take(files), () => !this.views.form.hidden);
    this.views.form.addEventListener("submit", () => this.trouble.replaceChildren(), true);
    addEventListener("popstate", () => void this.go());
    document.addEventListener("click", (event) => this.stayOnPage(event));
    void this.go();
  }

  /** Shows what the address names. */
  private async go(): Promise<void> {
    this.leave();
    const route = routeOf(location.pathname);
    switch (route.view) {
      case "form":
        return this.showForm();
      case "comparison":
        return this.open(route.id);
      case "batch":
        return this.openBatch(route.id);
      case "damaged":
        return this.damaged(route.of, route.id);
      case "unknown":
        this.show("none", "Not found · meshgauge");
        showTrouble(this.trouble, new Error(`There is no page ${route.path}.`), { form: () => this.toForm() });
    }
  }

  private async openBatch(id: string): Promise<void> {
    const signal = this.controller.signal;
    this.show("none", "meshgauge");
    try {
      await this.batches.open(id, signal, () => (this.running = id));
      if (!signal.aborted) this.running = null;
    } catch (error) {
      this.failed(error, signal, () => void this.go());
    }
  }

  private damaged(of: Linked, id: string): void {
    const repaired = idWithin(id);
    const suggestion = repaired === null ? null : h("p", {}, "It may have been this one: ", h("a", { href: pathOf(repaired, of) }, location.origin + pathOf(repaired, of)));
    this.over("This link is damaged", damagedWords(of, id), suggestion);
  }

  // Links to the page itself are followed without a reload, which keeps the chosen files, and a key that could not be stored.
  private stayOnPage(event: MouseEvent): void {
    const link = event.target instanceof Element ? event.target.closest("a") : null;
    const plain = event.button === 0 && !event.ctrlKey && !event.metaKey && !event.shiftKey && !event.altKey;
    const href = link?.getAttribute("href") ?? "";
    if (!plain || !(href === "/" || /^\/[bc]\//.test(href))) return;
    event.preventDefault();
    if (href === "/") return this.toForm();
    history.pushState(null, "", href);
    void this.go();
  }

  private toForm(): void {
    if (location.pathname !== "/") history.pushState(null, "", "/");
    this.leave();
    this.showForm();
  }

  private showForm(): void {
    this.show("form", "meshgauge: how far apart are two meshes?");
  }

  private leave(): void {
    this.controller.abort();
    this.controller = new AbortController();
    this.run?.dispose();
    this.run = null;
    this.running = null;
    this.endResult();
    this.endResult = () => undefined;
    this.trouble.replaceChildren();
    this.showWait(null);
  }

  private show(view: View, title: string): void {
    for (const [name, element] of Object.entries(this.views)) element.hidden = name !== view;
    document.body.dataset["view"] = view;
    document.title = title;
    scrollTo(0, 0);
  }

  private async begin(order: Order): Promise<void> {
    this.leave();
    const names = { a: nameOf(order.a), b: nameOf(order.b) };
    const signal = this.controller.signal;
    const run = this.openRun(names);
    const report = {
      upload: run.upload.bind(run),
      progress: run.progress.bind(run),
      interrupted: run.interrupted.bind(run),
      accepted: (job: Job) => {
        this.memories.set(job.id, { names, order });
        this.running = job.id;
        history.pushState(null, "", pathOf(job.id));
        run.accepted(job);
      },
    };
    try {
      await this.finish(await measure(this.client, order, report, signal), signal);
    } catch (error) {
      this.failed(error, signal, () => void this.begin(order), order);
    }
  }

  private async open(id: string): Promise<void> {
    const signal = this.controller.signal;
    this.show("none", "meshgauge");
    try {
      const job = await this.client.job(id, signal);
      if (hasEnded(job)) return await this.finish(job, signal);
      const memory = this.memories.get(id);
      const run = this.openRun(memory?.names ?? null);
      this.running = id;
      run.accepted(job);
      await this.finish(await watch(this.client, id, run, signal), signal);
    } catch (error) {
      this.failed(error, signal, () => void this.go());
    }
  }

  private openRun(names: Record<Side, string> | null): RunView {
    const face = { names, cancel: () => void this.cancel() };
    this.run = new RunView(this.views.run, face, this.announcer);
    this.show("run", "Measuring · meshgauge");
    this.run.focus();
    return this.run;
  }

  // Before the service has accepted the comparison, cancelling only stops the page: it goes back to where it was.
  private async cancel(): Promise<void> {
    const { running, run } = this;
    const { signal } = this.controller;
    if (running === null) return this.go();
    try {
      const job = await this.client.cancel(running);
      if (!signal.aborted && hasEnded(job)) await this.finishOr(job, signal);
    } catch (error) {
      if (signal.aborted || isAbort(error)) return;
      showTrouble(this.trouble, error, {});
      run?.mayCancel();
    }
  }

  private async finishOr(job: Job, signal: AbortSignal): Promise<void> {
    if (job.state !== "cancelled") this.announcer.sayNow("It had already ended.");
    try {
      await this.finish(job, signal);
    } catch (error) {
      this.failed(error, signal, () => void this.go(), this.memories.get(job.id)?.order);
    }
  }

  private async finish(job: Job, signal: AbortSignal): Promise<void> {
    const history = this.run?.history ?? null;
    this.running = null;
    if (job.problem) throw new ProblemError(job.problem, job.id, null);
    if (!job.result) return this.over("Cancelled", "It was cancelled before the measurement started, so there is no interval.");
    const { result } = job;
    const memory = this.memories.get(job.id);
    const names = memory?.names ?? (await this.namesOf(job));
    if (signal.aborted) return;
    this.leave();
    history?.add({ ms: Math.max(result.timings_ms.total - result.timings_ms.queue, history.last?.ms ?? 0), ...result.distance });
    this.show("result", titleOf(result));
    const timeout = memory?.order.options["timeout"];
    const timeoutMs = typeof timeout === "number" ? 1000 * timeout : null;
    const again = () => this.again(job, names);
    const narrow = () => void this.begin(orderToNarrow(result, names, memory?.order.options ?? {}));
    this.endResult = showResult(this.views.result, this.client, { job, result, names, history, timeoutMs, again, narrow });
    const words = wordingOf(result, timeoutMs);
    this.announcer.sayNow(`${words.heading}. ${words.reason}`);
    find("h1", HTMLElement, this.views.result).focus({ preventScroll: true });
  }

  private again(job: Job, names: Record<Side, string>): void {
    if (job.result) this.form.again(job.result, names, this.memories.get(job.id)?.order ?? null);
    this.toForm();
  }

  // The service keeps names with the meshes, which may be removed by now.
  private async namesOf(job: Job): Promise<Record<Side, string>> {
    const { result } = job;
    if (!result) return { a: "candidate", b: "baseline" };
    const otherwise = fallbackNames(result);
    const ask = (side: Side) =>
      this.client.mesh(result.meshes[side].sha256).then((mesh) => mesh.file_name ?? otherwise[side], () => otherwise[side]);
    const [a, b] = await Promise.all([ask("a"), ask("b")]);
    return { a, b };
  }

  // The comparison ended without a result.
  private over(title: string, words: string, more: HTMLElement | null = null): void {
    this.leave();
    this.show("none", `${title} · meshgauge`);
    const back = h("a", { class: "button", href: "/" }, "Back to the form");
    this.trouble.replaceChildren(h("div", { class: "trouble calm" }, h("h1", { tabindex: "-1" }, title), h("p", {}, words), more ?? "", back));
    this.announcer.sayNow(`${title}. ${words}`);
  }

  private failed(error: unknown, signal: AbortSignal, again: () => void, order?: Order): void {
    if (signal.aborted || isAbort(error)) return;
    if (this.running !== null) return this.lost(error);
    const where = order ? "form" : "none";
    if (order) this.toFormAddress(order);
    this.leave();
    this.show(where, "A problem · meshgauge");
    const explained = showTrouble(this.trouble, error, { again, form: order ? undefined : () => this.toForm() });
    if (!order) return;
    if (error instanceof ProblemError && error.kind === "unknown-mesh") for (const { part } of explained.defects) this.forgetStored(part, order);
    this.form.blame(explained.defects);
  }

  // The view before stays one step back in the history; a failed start is not a place to go back to.
  private toFormAddress(order: Order): void {
    const route = routeOf(location.pathname);
    const own = route.view === "comparison" && this.memories.get(route.id)?.order === order;
    if (own) history.replaceState(null, "", "/");
    else if (route.view !== "form") history.pushState(null, "", "/");
  }

  // The comparison goes on without the page: its link stays valid.
  private lost(error: unknown): void {
    this.leave();
    this.show("none", "A problem · meshgauge");
    showTrouble(this.trouble, error, { look: () => void this.go(), form: () => this.toForm() });
  }

  private forgetStored(part: string, order: Order): void {
    if ((part === "a" || part === "b") && order[part].kind === "stored") this.form.forget(part);
  }

  private showWait(wait: { seconds: number; title: string } | null): void {
    this.waiting.hidden = wait === null;
    if (!wait) return;
    const words = `${wait.title}. Trying again in ${String(wait.seconds)} ${wait.seconds === 1 ? "second" : "seconds"}.`;
    this.waiting.textContent = words;
    this.announcer.say(words);
  }
}

/** The same meshes, which the service has, and the same options without the limits. */
function orderToNarrow(result: Comparison, names: Record<Side, string>, known: Json): Order {
  const options = withoutLimits({ ...known, ...optionsOf(result) });
  const stored = (side: Side): Chosen => ({ kind: "stored", id: result.meshes[side].sha256, name: names[side], bytes: result.meshes[side].bytes });
  return { a: stored("a"), b: stored("b"), options };
}

new App().start();
