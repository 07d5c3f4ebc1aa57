import assert from "node:assert/strict";
import { test } from "node:test";
import { EventParser, eventsOf } from "../../../server/web/page/api/sse.js";

const stream = 'event: progress\ndata: {"lower":0}\n\n: still here\n\nevent: end\ndata: {"id":"x"}\n\n';
const told = [
  { name: "progress", data: '{"lower":0}' },
  { name: "end", data: '{"id":"x"}' },
];

function parse(...pieces: string[]) {
  const parser = new EventParser();
  return pieces.flatMap((piece) => parser.push(piece));
}

test("events of one piece", () => assert.deepEqual(parse(stream), told));

test("events cut at every place", () => {
  for (let at = 0; at <= stream.length; ++at) assert.deepEqual(parse(stream.slice(0, at), stream.slice(at)), told, String(at));
});

test("events that come letter by letter", () => assert.deepEqual(parse(...stream), told));

test("CRLF and lone CR end lines, also cut between the two", () => {
  const crlf = stream.replaceAll("\n", "\r\n");
  for (let at = 0; at <= crlf.length; ++at) assert.deepEqual(parse(crlf.slice(0, at), crlf.slice(at)), told, String(at));
  assert.deepEqual(parse(...crlf), told);
  assert.deepEqual(parse(stream.replaceAll("\n", "\r"), "\n"), told);
});

test("several lines of data are one text", () => {
  assert.deepEqual(parse("data: one\ndata:two\ndata\n\n"), [{ name: "message", data: "one\ntwo\n" }]);
});

test("one space after the colon does not count, a second one does", () => {
  assert.deepEqual(parse("data:  x\n\n"), [{ name: "message", data: " x" }]);
});

test("comments, unknown fields and events without data are ignored", () => {
  assert.deepEqual(parse(": hi\nid: 1\nretry: 5\nfoo\n\nevent: lonely\n\n"), []);
});

test("a name counts for its own event alone", () => {
  assert.deepEqual(parse("event: a\ndata: 1\n\ndata: 2\n\n").map(({ name }) => name), ["a", "message"]);
});

test("a byte order mark at the beginning is none of the text", () => {
  assert.deepEqual(parse("\uFEFFdata: 1\n\n"), [{ name: "message", data: "1" }]);
});

test("an event cut off by the end of the stream is dropped", () => assert.deepEqual(parse("data: 1\n"), []));

test("letters of several bytes that are cut between two pieces", async () => {
  const bytes = new TextEncoder().encode("data: µ€😀\n\n");
  for (let at = 0; at <= bytes.length; ++at) {
    const body = new ReadableStream<Uint8Array>({
      start(controller) {
        controller.enqueue(bytes.slice(0, at));
        controller.enqueue(bytes.slice(at));
        controller.close();
      },
    });
    const events = [];
    for await (const event of eventsOf(body)) events.push(event);
    assert.deepEqual(events, [{ name: "message", data: "µ€😀" }], String(at));
  }
});

test("a broken stream is an error, after the events before it", async () => {
  let pulled = 0;
  const body = new ReadableStream<Uint8Array>({
    pull(controller) {
      if (pulled++ === 0) controller.enqueue(new TextEncoder().encode("data: 1\n\n"));
      else controller.error(new TypeError("gone"));
    },
  });
  const seen: string[] = [];
  await assert.rejects(async () => {
    for await (const { data } of eventsOf(body)) seen.push(data);
  }, /gone/);
  assert.deepEqual(seen, ["1"]);
});
