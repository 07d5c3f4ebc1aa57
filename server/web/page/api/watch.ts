// Watches a comparison or a batch until it has ended: by its events, and by polling if these are refused or break off.
import { batchAt, isAbort, pause, type Client } from "./client.js";
import { NetworkError, ProblemError } from "./problem.js";
import { hasEnded, type Batch, type BatchProgressEvent, type Job, type ProgressEvent } from "./types.js";

export interface Watcher<Progress> {
  progress(event: Progress): void;
  /** The stream broke. The work goes on and is polled. */
  interrupted(): void;
}

/** What can be watched. */
interface Watched<Progress, State> {
  path: string; // of the events
  doing: string; // completes "there was no answer while ..."
  ask(signal: AbortSignal): Promise<State>;
  toEvent(state: State): Progress;
}

const firstPauseMs = 500;
const longestPauseMs = 5000;
const maxFailedPolls = 12; // failed polls in a row

export function watch(client: Client, id: string, watcher: Watcher<ProgressEvent>, signal: AbortSignal): Promise<Job> {
  const comparison: Watched<ProgressEvent, Job> = {
    path: `/v1/comparisons/${id}/events`,
    doing: "watching the comparison",
    ask: (its) => client.job(id, its),
    toEvent: (job) => toEvent(job, Date.now()),
  };
  return watched(client, comparison, watcher, signal);
}

export function watchBatch(client: Client, id: string, watcher: Watcher<BatchProgressEvent>, signal: AbortSignal): Promise<Batch> {
  const batch: Watched<BatchProgressEvent, Batch> = {
    path: `/v1/batches/${id}/events`,
    doing: "watching the batch",
    ask: (its) => batchAt(client, id, its),
    toEvent: ({ state, counts }) => ({ state, counts }),
  };
  return watched(client, batch, watcher, signal);
}

async function watched<Progress, State extends Job | Batch>(
  client: Client,
  what: Watched<Progress, State>,
  watcher: Watcher<Progress>,
  signal: AbortSignal,
): Promise<State> {
  let wait = firstPauseMs;
  for (let failedPolls = 0; ; ) {
    const seen = await follow(client, what, watcher, signal);
    if (seen.end) return seen.end;
    if (seen.any) wait = firstPauseMs;
    watcher.interrupted();
    try {
      const state = await what.ask(signal);
      if (hasEnded(state)) return state;
      failedPolls = 0;
      watcher.progress(what.toEvent(state));
    } catch (error) {
      if (!(error instanceof NetworkError) || ++failedPolls === maxFailedPolls) throw error;
    }
    await pause(wait, signal);
    wait = Math.min(2 * wait, longestPauseMs);
  }
}

interface Seen<State> {
  end: State | null;
  any: boolean;
}

async function follow<Progress, State extends Job | Batch>(
  client: Client,
  what: Watched<Progress, State>,
  watcher: Watcher<Progress>,
  signal: AbortSignal,
): Promise<Seen<State>> {
  let any = false;
  try {
    for await (const event of client.events<Progress, State>(what.path, { signal, doing: what.doing })) {
      if ("end" in event) return { end: hasEnded(event.end) ? event.end : null, any: true }; // null: the service stops, and the job goes on elsewhere
      any = true;
      watcher.progress(event.progress);
    }
  } catch (error) {
    if (isAbort(error) || (error instanceof ProblemError && !mayPass(error))) throw error;
  }
  return { end: null, any };
}

function mayPass(error: ProblemError): boolean {
  return error.problem.status === 429 || error.problem.status === 503;
}

/** Converts the document of GET to an event. `now`: as Date.now(). */
export function toEvent(job: Job, now: number): ProgressEvent {
  const since = Date.parse(job.started ?? job.created);
  return {
    state: job.state,
    lower: job.progress?.lower ?? 0,
    upper: job.progress?.upper ?? null,
    stage: job.progress?.stage ?? null,
    elapsed_ms: Math.max(0, now - since),
  };
}
