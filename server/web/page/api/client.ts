// Requests to the service that the page came from. Each throws ProblemError, NetworkError, or DOMException AbortError.
import { NetworkError, ProblemError, toError } from "./problem.js";
import { eventsOf, textOf } from "./sse.js";
import type { Batch, BatchResult, Job, StoredMesh, StoredPair } from "./types.js";

export const keyName = "meshgauge.key";
const mostTries = 60; // tries of one request that the service asks to repeat later

export interface Call {
  method?: string;
  body?: string;
  headers?: Record<string, string>;
  signal?: AbortSignal | undefined;
  doing: string; // completes "there was no answer while ..."
}

/** Called before each wait for a busy service with its seconds and the reason; with null when the wait is over. */
export type OnWait = (wait: { seconds: number; title: string } | null) => void;

/** True if a header can carry the key: fetch() refuses other letters, and no key has them. */
export function isKey(text: string): boolean {
  return /^[\x21-\x7e]+$/.test(text);
}

/** Asks the user for a key; false: none was entered. */
export type AskKey = () => Promise<boolean>;

export class Client {
  private asking: Promise<boolean> | null = null;
  private unstored = ""; // the key, where the browser forbids storage

  constructor(
    private readonly onWait: OnWait = () => undefined,
    private readonly askKey: AskKey = () => Promise.resolve(false),
  ) {}

  get key(): string {
    try {
      return sessionStorage.getItem(keyName) ?? this.unstored;
    } catch {
      return this.unstored;
    }
  }

  set key(value: string) {
    this.unstored = value;
    try {
      if (value === "") sessionStorage.removeItem(keyName);
      else sessionStorage.setItem(keyName, value);
    } catch {
      // Site data is blocked: the key lives as long as the page.
    }
  }

  authorization(): Record<string, string> {
    return this.key === "" ? {} : { Authorization: `Bearer ${this.key}` };
  }

  /** Sends one request, and again with a key if one is needed. Throws unless it succeeds. */
  async send(path: string, call: Call): Promise<Response> {
    return this.authorized(() => this.sendOnce(path, call));
  }

  /** Requests that are refused at the same time share one question for a key. */
  async authorized<T>(once: () => Promise<T>): Promise<T> {
    for (;;) {
      const key = this.key;
      try {
        return await once();
      } catch (error) {
        if (!(error instanceof ProblemError) || error.problem.status !== 401) throw error;
        if (this.key !== key) continue;
        this.asking ??= this.askKey().finally(() => (this.asking = null));
        if (!(await this.asking)) throw error;
      }
    }
  }

  private async sendOnce(path: string, call: Call): Promise<Response> {
    const init: RequestInit = {
      method: call.method ?? "GET",
      headers: { ...this.authorization(), ...call.headers },
      body: call.body ?? null,
      signal: call.signal ?? null,
      cache: "no-store",
      credentials: "same-origin",
    };
    const answer = await fetch(path, init).catch((error: unknown) => {
      throw call.signal?.aborted ? error : new NetworkError(call.doing);
    });
    if (answer.ok) return answer;
    throw toError(answer.status, await answer.text().catch(() => ""), (name) => answer.headers.get(name));
  }

  /** As send(), but repeats the request when the service asks for it (429, 503). */
  async sendWithRetries(path: string, call: Call): Promise<Response> {
    return this.withRetries(() => this.send(path, call), call.signal);
  }

  async withRetries<T>(once: () => Promise<T>, signal?: AbortSignal): Promise<T> {
    for (let tries = 1; ; ++tries) {
      try {
        return await once();
      } catch (error) {
        if (!(error instanceof ProblemError) || !asksToWait(error) || tries === mostTries) throw error;
        await this.waitFor(error, signal);
      }
    }
  }

  private async waitFor(error: ProblemError, signal?: AbortSignal): Promise<void> {
    const seconds = error.retryAfterSeconds ?? 1;
    this.onWait({ seconds, title: error.problem.title });
    try {
      await pause(seconds * 1000, signal);
    } finally {
      this.onWait(null);
    }
  }

  async job(id: string, signal?: AbortSignal): Promise<Job> {
    const answer = await this.sendWithRetries(`/v1/comparisons/${id}`, { signal, doing: "asking how the comparison stands" });
    return (await answer.json()) as Job;
  }

  async begin(pair: StoredPair, once: string, signal?: AbortSignal): Promise<Job> {
    const answer = await this.sendWithRetries("/v1/comparisons", {
      method: "POST",
      body: JSON.stringify(pair),
      headers: { "Content-Type": "application/json", Prefer: "respond-async", "Idempotency-Key": once },
      signal,
      doing: "starting the comparison",
    });
    if (answer.status === 202) return (await answer.json()) as Job;
    // The Idempotency-Key was known and its comparison has ended: the response is the result alone.
    const { id } = (await answer.json()) as { id: string };
    return this.job(id, signal);
  }

  /** Lets the service read options before meshes are sent: throws what it finds wrong. */
  async read(options: StoredPair["options"], signal?: AbortSignal): Promise<void> {
    const headers = { "Content-Type": "application/json" };
    await this.sendWithRetries("/v1/options", { method: "POST", body: JSON.stringify(options), headers, signal, doing: "asking about the settings" });
  }

  /** Cancels a comparison; nothing happens to one that has ended. */
  async cancel(id: string): Promise<Job> {
    const answer = await this.sendWithRetries(`/v1/comparisons/${id}/cancel`, { method: "POST", doing: "cancelling the comparison" });
    return (await answer.json()) as Job;
  }

  async mesh(id: string): Promise<StoredMesh> {
    const answer = await this.send(`/v1/meshes/${id}`, { doing: "asking for a mesh" });
    return (await answer.json()) as StoredMesh;
  }

  /** Yields progress events, then the ended comparison; returns early if the stream does. */
  async *events<Progress, State>(path: string, call: Call): AsyncGenerator<{ progress: Progress } | { end: State }, void, undefined> {
    const answer = await this.send(path, call);
    if (!answer.body) return;
    for await (const event of eventsOf(answer.body)) {
      if (event.name === "progress") yield { progress: JSON.parse(event.data) as Progress };
      if (event.name !== "end") continue;
      const end = JSON.parse(event.data) as State | null; // null: it was forgotten meanwhile
      if (end !== null) yield { end };
      return;
    }
  }
}

// out-of-time is final: the same request would run out of time again.
function asksToWait(error: ProblemError): boolean {
  const { status } = error.problem;
  return error.kind !== "out-of-time" && (status === 429 || status === 503);
}

export type Report = "junit.xml" | "results.jsonl";

const batchPath = (id: string): string => `/v1/batches/${id}`;

export async function batchAt(client: Client, id: string, signal?: AbortSignal): Promise<Batch> {
  const answer = await client.sendWithRetries(batchPath(id), { signal, doing: "asking how the batch stands" });
  return (await answer.json()) as Batch;
}

/** Cancels a batch; nothing happens to one that has ended. */
export async function cancelBatch(client: Client, id: string): Promise<Batch> {
  const answer = await client.sendWithRetries(`${batchPath(id)}/cancel`, { method: "POST", doing: "cancelling the batch" });
  return (await answer.json()) as Batch;
}

export async function reportOf(client: Client, id: string, report: Report, signal?: AbortSignal): Promise<Response> {
  return client.sendWithRetries(`${batchPath(id)}/${report}`, { signal, doing: "reading the results" });
}

/** Yields the ended comparisons in the order of the manifest, in portions as they arrive. */
export async function* resultsOf(client: Client, id: string, signal: AbortSignal): AsyncGenerator<BatchResult[], void, undefined> {
  const answer = await reportOf(client, id, "results.jsonl", signal);
  if (!answer.body) return;
  for await (const lines of linesOf(answer.body, signal)) yield lines.map((line) => JSON.parse(line) as BatchResult);
}

async function* linesOf(body: ReadableStream<Uint8Array>, signal: AbortSignal): AsyncGenerator<string[], void, undefined> {
  let rest = "";
  try {
    for await (const text of textOf(body)) {
      const lines = (rest + text).split("\n");
      rest = lines.pop() ?? "";
      if (lines.length > 0) yield lines;
    }
  } catch (error) {
    throw signal.aborted ? error : new NetworkError("reading the results");
  }
}

export function pause(ms: number, signal?: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    const stop = () => {
      clearTimeout(timer);
      reject(new DOMException("stopped", "AbortError"));
    };
    if (signal?.aborted) return void reject(new DOMException("stopped", "AbortError"));
    const timer = setTimeout(() => {
      signal?.removeEventListener("abort", stop);
      resolve();
    }, ms);
    signal?.addEventListener("abort", stop, { once: true });
  });
}

export function isAbort(error: unknown): boolean {
  return error instanceof DOMException && error.name === "AbortError";
}
