// Requests about a batch. They throw as those of Client.
import type { Client } from "./client.js";
import { NetworkError } from "./problem.js";
import type { Batch, BatchResult } from "./types.js";

export type Report = "junit.xml" | "results.jsonl";

const pathOf = (id: string): string => `/v1/batches/${id}`;

export async function batchAt(client: Client, id: string, signal?: AbortSignal): Promise<Batch> {
  const answer = await client.sendWithRetries(pathOf(id), { signal, doing: "asking how the batch stands" });
  return (await answer.json()) as Batch;
}

/** Cancels a batch; nothing happens to one that has ended. */
export async function cancelBatch(client: Client, id: string): Promise<Batch> {
  const answer = await client.sendWithRetries(`${pathOf(id)}/cancel`, { method: "POST", doing: "cancelling the batch" });
  return (await answer.json()) as Batch;
}

export async function reportOf(client: Client, id: string, report: Report, signal?: AbortSignal): Promise<Response> {
  return client.sendWithRetries(`${pathOf(id)}/${report}`, { signal, doing: "reading the results" });
}

/** Yields the ended comparisons in the order of the manifest, in portions as they arrive. */
export async function* resultsOf(client: Client, id: string, signal: AbortSignal): AsyncGenerator<BatchResult[], void, undefined> {
  const answer = await reportOf(client, id, "results.jsonl", signal);
  if (!answer.body) return;
  for await (const lines of linesOf(answer.body, signal)) yield lines.map((line) => JSON.parse(line) as BatchResult);
}

async function* linesOf(body: ReadableStream<Uint8Array>, signal: AbortSignal): AsyncGenerator<string[], void, undefined> {
  const reader = body.pipeThrough(new TextDecoderStream() as ReadableWritablePair<string, Uint8Array>).getReader();
  let rest = "";
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      const lines = (rest + value).split("\n");
      rest = lines.pop() ?? "";
      if (lines.length > 0) yield lines;
    }
  } catch (error) {
    throw signal.aborted ? error : new NetworkError("reading the results");
  } finally {
    reader.cancel().catch(() => undefined); // a reader that stops early releases the connection
  }
}
