import assert from "node:assert/strict";
import { test } from "node:test";
import { NetworkError, ProblemError, toError } from "../../../server/web/page/api/problem.js";
import { explain, explainProblem } from "../../../server/web/page/text/problems.js";

const none = () => null;
const document = (kind: string, status: number, detail: string, errors: { part: string; where: string; message: string }[] = []) => ({
  type: `/problems/${kind}`, title: `title of ${kind}`, status, detail, errors,
});

test("a problem's document, request id and Retry-After", () => {
  const headers: Record<string, string> = { "X-Request-Id": "ab12", "Retry-After": "7" };
  const error = toError(503, JSON.stringify(document("overloaded", 503, "the queue is full")), (name) => headers[name] ?? null);
  assert.equal(error.kind, "overloaded");
  assert.equal(error.requestId, "ab12");
  assert.equal(error.retryAfterSeconds, 7);
});

test("the kind of a problem that a job of version 0.1 has", () => {
  const stored = { ...document("cancelled", 409, "it was cancelled"), type: "urn:meshgauge:problem:cancelled" };
  assert.equal(toError(409, JSON.stringify(stored), none).kind, "cancelled");
});

test("a response without a problem document still becomes a problem", () => {
  for (const body of ["", "<html>502</html>", "null", "{}", '{"type":"x","title":"t","status":"5","detail":"d","errors":[]}', '{"type":"x","title":"t","status":5,"detail":"d","errors":[null]}']) {
    const error = toError(502, body, none);
    assert.equal(error.problem.status, 502, body);
    assert.match(error.problem.detail, /status 502/);
  }
  assert.equal(toError(401, "", none).kind, "unauthorized");
});

test("a Retry-After that is no number of seconds is none", () => {
  assert.equal(toError(503, "", (name) => (name === "Retry-After" ? "soon" : null)).retryAfterSeconds, null);
  assert.equal(toError(503, "", (name) => (name === "Retry-After" ? "0" : null)).retryAfterSeconds, 1);
});

test("a defect of a mesh is shown once, at the mesh", () => {
  const message = "line 3 of 'a': '2,5' is not a number";
  const told = explainProblem(document("unreadable-mesh", 422, message, [{ part: "a", where: "line 3", message }]), "ab12");
  assert.deepEqual(told.defects, [{ part: "a", label: "Candidate (A)", where: "line 3", message }]);
  assert.equal(told.detail, "");
  assert.match(told.advice, /export it again/);
  assert.equal(told.retry, false);
});

test("defects of the options and of the rest", () => {
  const told = explainProblem(document("not-ready", 503, "several", [{ part: "options", where: "/gate", message: "m" }, { part: "queue", where: "", message: "n" }]), null);
  assert.deepEqual(told.defects.map(({ part, label }) => [part, label]), [["options", "Settings"], ["other", "queue"]]);
  assert.equal(told.detail, "Several.");
});

test("a link to nothing says what may have happened", () => {
  const told = explainProblem(document("not-found", 404, "no comparison has this id, or it is no longer stored"), null);
  assert.match(told.title, /no such comparison/);
  assert.match(told.advice, /mistyped.*no longer be kept.*another key/);
});

test("another thing that is not found keeps its own words", () => {
  const told = explainProblem(document("not-found", 404, "the mesh 'a' is no longer kept"), null);
  assert.equal(told.detail, "The mesh 'a' is no longer kept.");
});

test("a kind that this page does not know yet is shown in the service's words", () => {
  const told = explainProblem(document("brand-new", 409, "it runs"), null);
  assert.deepEqual([told.title, told.detail, told.advice], ["title of brand-new", "It runs.", ""]);
});

test("no response is reported and can be retried", () => {
  const told = explain(new NetworkError("sending part.stl"));
  assert.match(told.detail, /while sending part.stl/);
  assert.equal(told.retry, true);
});

test("only temporary problems can be retried", () => {
  const retry = (kind: string) => explain(new ProblemError(document(kind, 500, "d"), null, null)).retry;
  assert.deepEqual(["overloaded", "too-many-requests", "unreadable-mesh", "invalid-request", "not-found"].map(retry), [true, true, false, false, false]);
});

test("a failure of the page itself is reported", () => {
  assert.equal(explain(new Error("boom")).detail, "boom");
  assert.equal(explain("odd").detail, "odd");
});
