// A measurement from the files to the ended comparison: stores both meshes, starts it, watches it.
import type { Client } from "../api/client.js";
import { ProblemError } from "../api/problem.js";
import { hasEnded, type Job, type ProgressEvent, type Side } from "../api/types.js";
import { store, type UploadStep } from "../api/upload.js";
import { watch } from "../api/watch.js";
import type { Chosen, Order } from "../form/form.js";

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
function newKey(): string {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}
