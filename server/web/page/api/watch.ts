// A comparison until it has ended: by its events, and by asking where these are refused or break off.
import { isAbort, pause, type Client } from "./client.js";
import { NetworkError, ProblemError } from "./problem.js";
import { hasEnded, type Job, type ProgressEvent } from "./types.js";

export interface Watcher {
  progress(event: ProgressEvent): void;
  /** The stream broke: the comparison goes on, and is asked for. */
  interrupted(): void;
}

const firstPauseMs = 500;
const longestPauseMs = 5000;
const mostSilences = 12; // answers that did not come, one after the other

export async function watch(client: Client, id: string, watcher: Watcher, signal: AbortSignal): Promise<Job> {
  let wait = firstPauseMs;
  for (let silences = 0; ; ) {
    const seen = await follow(client, id, watcher, signal);
    if (seen.end) return seen.end;
    if (seen.any) wait = firstPauseMs;
    watcher.interrupted();
    try {
      const job = await client.job(id, signal);
      if (hasEnded(job)) return job;
      silences = 0;
      watcher.progress(toEvent(job, Date.now()));
    } catch (error) {
      if (!(error instanceof NetworkError) || ++silences === mostSilences) throw error;
    }
    await pause(wait, signal);
    wait = Math.min(2 * wait, longestPauseMs);
  }
}

interface Seen {
  end: Job | null;
  any: boolean;
}

async function follow(client: Client, id: string, watcher: Watcher, signal: AbortSignal): Promise<Seen> {
  let any = false;
  try {
    for await (const event of client.events(id, signal)) {
      if ("id" in event) return { end: event, any: true };
      any = true;
      watcher.progress(event);
    }
  } catch (error) {
    if (isAbort(error) || (error instanceof ProblemError && !mayPass(error))) throw error;
  }
  return { end: null, any };
}

function mayPass(error: ProblemError): boolean {
  return error.problem.status === 429 || error.problem.status === 503;
}

/** What GET says, in the form of an event. `now` as Date.now(). */
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
