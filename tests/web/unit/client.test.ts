import assert from "node:assert/strict";
import { afterEach, beforeEach, test } from "node:test";
import { Client, isKey, pause, resultsOf } from "../../../server/web/page/api/client.js";
import { NetworkError, ProblemError } from "../../../server/web/page/api/problem.js";
import type { Job, ProgressEvent } from "../../../server/web/page/api/types.js";
import { watch, watchBatch } from "../../../server/web/page/api/watch.js";
import { comparison } from "./samples.js";

const id = "0d67c9a2d1b307386f8fc157855c4351";
const job = (state: Job["state"]): Job => ({
  id, state, created: "2026-03-01T12:00:00.000Z", started: "2026-03-01T12:00:00.000Z", finished: null, expires: null, tries: 1, gate: null,
  progress: state === "running" ? { lower: 1, upper: 2, stage: "reduce" } : null, result: state === "done" ? comparison() : null, problem: null,
});
const running = 'event: progress\ndata: {"state":"running","lower":1,"upper":3,"stage":"traverse","elapsed_ms":5}\n\n';
const end = `event: end\ndata: ${JSON.stringify(job("done"))}\n\n`;

interface Asked {
  path: string;
  key: string | null;
}

let asked: Asked[] = [];
let answers: (() => Response | Promise<Response>)[] = [];
const storage = new Map<string, string>();
const real = globalThis.fetch;

beforeEach(() => {
  asked = [];
  answers = [];
  storage.clear();
  const session = { getItem: (name: string) => storage.get(name) ?? null, setItem: (name: string, value: string) => storage.set(name, value), removeItem: (name: string) => storage.delete(name) };
  Object.assign(globalThis, {
    sessionStorage: session,
    fetch: async (path: string, init: RequestInit) => {
      asked.push({ path, key: new Headers(init.headers).get("Authorization") });
      const answer = answers.shift();
      if (!answer) throw new Error(`unexpected request ${path}`);
      return answer();
    },
  });
});
afterEach(() => void (globalThis.fetch = real));

const json = (value: unknown, status = 200, headers: Record<string, string> = {}) => () => new Response(JSON.stringify(value), { status, headers });
const refuse = (kind: string, status: number, headers: Record<string, string> = {}) =>
  json({ type: `/problems/${kind}`, title: kind, status, detail: kind, errors: [] }, status, headers);
const broken = () => Promise.reject(new TypeError("failed to fetch"));
const stream = (text: string) => () => new Response(text);
const never = new AbortController().signal;

test("a busy service is retried, and the wait is reported", async () => {
  const waits: (number | null)[] = [];
  answers = [refuse("overloaded", 503, { "Retry-After": "1" }), json(job("done"))];
  const told = await new Client((wait) => waits.push(wait?.seconds ?? null)).job(id);
  assert.equal(told.state, "done");
  assert.deepEqual(waits, [1, null]);
});

test("out-of-time is not retried", async () => {
  answers = [refuse("out-of-time", 503, { "Retry-After": "1" })];
  await assert.rejects(new Client().job(id), (error) => error instanceof ProblemError && error.kind === "out-of-time");
});

test("aborting ends a wait", async () => {
  const controller = new AbortController();
  answers = [refuse("overloaded", 503, { "Retry-After": "60" })];
  const told = new Client().job(id, controller.signal);
  setTimeout(() => controller.abort(), 20);
  await assert.rejects(told, { name: "AbortError" });
  await assert.rejects(pause(10, controller.signal), { name: "AbortError" });
});

test("a key is asked for, kept, and sent; without one the refusal stays", async () => {
  answers = [refuse("unauthorized", 401), json(job("done"))];
  const client: Client = new Client(undefined, () => {
    client.key = "mg_1";
    return Promise.resolve(true);
  });
  await client.job(id);
  assert.deepEqual(asked.map(({ key }) => key), [null, "Bearer mg_1"]);
  assert.equal(storage.size, 1);
  answers = [refuse("unauthorized", 401)];
  await assert.rejects(new Client(undefined, () => Promise.resolve(false)).job(id), ProblemError);
});

test("without storage the key lives as long as the page", async () => {
  const blocked = () => {
    throw new DOMException("The operation is insecure.", "SecurityError");
  };
  Object.defineProperty(globalThis, "sessionStorage", { get: blocked, configurable: true });
  try {
    const client = new Client();
    assert.equal(client.key, "");
    client.key = "mg_1";
    answers = [json(job("done"))];
    await client.job(id);
    assert.deepEqual(asked.map(({ key }) => key), ["Bearer mg_1"]);
  } finally {
    Object.defineProperty(globalThis, "sessionStorage", { value: undefined, configurable: true, writable: true });
  }
});

test("a key that no header can carry is refused", () => {
  assert.deepEqual(["mg_abc-1", "mg_ä", "mg_„x“", "a b", "", "mg_\n"].map(isKey), [true, false, false, false, false, false]);
});

test("two requests that are refused together ask for one key", async () => {
  let times = 0;
  answers = [refuse("unauthorized", 401), refuse("unauthorized", 401), json(job("done")), json(job("done"))];
  const client: Client = new Client(undefined, async () => {
    ++times;
    await pause(5);
    client.key = "mg_1";
    return true;
  });
  await Promise.all([client.job(id), client.job(id)]);
  assert.equal(times, 1);
});

test("no response is a network error that says what was being done", async () => {
  answers = [broken];
  await assert.rejects(new Client().job(id), (error) => error instanceof NetworkError && /how the comparison stands/.test(error.message));
});

async function watched(...given: typeof answers) {
  answers = given;
  const seen: ProgressEvent[] = [];
  let breaks = 0;
  const last = await watch(new Client(), id, { progress: (event) => void seen.push(event), interrupted: () => void ++breaks }, never);
  return { last, seen, breaks };
}

test("watching: events until the end", async () => {
  const { last, seen, breaks } = await watched(stream(running + end));
  assert.equal(last.state, "done");
  assert.deepEqual(seen.map(({ upper }) => upper), [3]);
  assert.equal(breaks, 0);
});

test("watching: after a broken stream the comparison is polled and watched again", async () => {
  const { last, seen, breaks } = await watched(stream(running), json(job("running")), stream(end));
  assert.equal(last.state, "done");
  assert.deepEqual(seen.map(({ upper }) => upper), [3, 2]);
  assert.equal(breaks, 1);
  assert.deepEqual(asked.map(({ path }) => path), [`/v1/comparisons/${id}/events`, `/v1/comparisons/${id}`, `/v1/comparisons/${id}/events`]);
});

test("watching: a refused event stream is replaced by polling", async () => {
  const { last } = await watched(refuse("overloaded", 503), json(job("done")));
  assert.equal(last.state, "done");
});

test("watching: a service that is away for a moment", async () => {
  const { last } = await watched(broken, broken, stream(end));
  assert.equal(last.state, "done");
});

test("watching: a comparison that is gone is an error at once", async () => {
  await assert.rejects(watched(refuse("not-found", 404)), (error) => error instanceof ProblemError && error.kind === "not-found");
});

test("watching: an end event of a stopping service is not the job's end", async () => {
  answers = [stream(`event: end\ndata: ${JSON.stringify(job("running"))}\n\n`), json(job("done"))];
  const silent = { progress: () => undefined, interrupted: () => undefined };
  assert.equal((await watch(new Client(), id, silent, never)).state, "done");
  assert.equal(asked.length, 2);
});

test("watching a batch: through a break, and through a forgotten one", async () => {
  const counts = { total: 2, queued: 0, running: 1, done: 1, failed: 0, cancelled: 0, gone: 0, pass: 1, fail: 0, undecided: 0 };
  const batch = (state: string) => ({ id, name: null, state, created: "", finished: null, expires: null, counts, failures: [], running: [] });
  answers = [stream(`event: progress\ndata: ${JSON.stringify({ state: "running", counts })}\n\n`), json(batch("running")), stream(`event: end\ndata: ${JSON.stringify(batch("done"))}\n\n`)];
  const seen: number[] = [];
  const watcher = { progress: (event: { counts: { done: number } }) => void seen.push(event.counts.done), interrupted: () => void seen.push(-1) };
  assert.equal((await watchBatch(new Client(), id, watcher, never)).state, "done");
  assert.deepEqual(seen, [1, -1, 1]);
  assert.deepEqual(asked.map(({ path }) => path), [`/v1/batches/${id}/events`, `/v1/batches/${id}`, `/v1/batches/${id}/events`]);
  answers = [stream("event: end\ndata: null\n\n"), refuse("not-found", 404)];
  await assert.rejects(watchBatch(new Client(), id, watcher, never), (error) => error instanceof ProblemError && error.kind === "not-found");
});

test("results are parsed line by line wherever they are cut, and a break is a network error", async () => {
  const pieces = ['{"position":0}\n{"posi', 'tion":1}\n', '{"position":2}\n{"pos'];
  const cut = (end: (to: ReadableStreamDefaultController) => void) => () => {
    const left = [...pieces];
    return new Response(new ReadableStream({
      pull: (to) => {
        const piece = left.shift();
        if (piece === undefined) end(to);
        else to.enqueue(new TextEncoder().encode(piece));
      },
    }));
  };
  const read = async () => {
    const places: number[] = [];
    for await (const some of resultsOf(new Client(), id, never)) places.push(...some.map(({ position }) => position));
    return places;
  };
  answers = [cut((to) => to.close())];
  assert.deepEqual(await read(), [0, 1, 2]);
  answers = [cut((to) => to.error(new TypeError("network error")))];
  await assert.rejects(read(), NetworkError);
});

test("starting again with the Idempotency-Key of an ended comparison returns it", async () => {
  answers = [json(comparison({ id })), json(job("done"))];
  const told = await new Client().begin({ a: "a".repeat(64), b: "b".repeat(64), options: {} }, "once");
  assert.equal(told.state, "done");
  assert.equal(asked.at(-1)?.path, `/v1/comparisons/${id}`);
});
