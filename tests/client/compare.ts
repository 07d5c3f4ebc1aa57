// A client as a user would write it, by types that were generated from openapi.yaml: one comparison, and one as a job.
import type { components, paths } from "./api.js";

type Comparison = components["schemas"]["Comparison"];
type Problem = components["schemas"]["Problem"];
type Job = components["schemas"]["Job"];
type Create = paths["/v1/comparisons"]["post"];
type ByIds = Create["requestBody"]["content"]["application/json"];
type Stored = paths["/v1/meshes"]["post"]["responses"][201]["content"]["application/json"];

const server = process.argv[2] ?? "http://127.0.0.1:8080";

function square(height: number): Blob {
  return new Blob([`v 0 0 ${height}\nv 1 0 ${height}\nv 1 1 ${height}\nf 1 2 3\n`], { type: "model/obj" });
}

async function told<T>(answer: Response, ...expected: number[]): Promise<T> {
  if (expected.includes(answer.status)) return (await answer.json()) as T;
  const problem = (await answer.json()) as Problem;
  throw new Error(`${problem.status} ${problem.type}: ${problem.detail}`);
}

function check(comparison: Comparison): void {
  const { lower, upper } = comparison.distance;
  if (upper === null || lower > 2 || upper < 2 || comparison.verdict !== "pass") throw new Error(JSON.stringify(comparison));
  console.log(`${comparison.status}: the distance is in [${lower}, ${upper}]`);
}

async function fromFiles(): Promise<void> {
  const options: components["schemas"]["Options"] = { tolerance: { absolute: 1e-6 }, gate: { max_distance: 3, units: "mm" } };
  const form = new FormData();
  form.append("a", square(0), "a.obj");
  form.append("b", square(2), "b.obj");
  form.append("options", JSON.stringify(options));
  const answer = await fetch(`${server}/v1/comparisons`, { method: "POST", body: form });
  check(await told<Create["responses"][200]["content"]["application/json"]>(answer, 200));
}

async function asJob(): Promise<void> {
  const ids = await Promise.all([0, 2].map(async (height) => {
    const answer = await fetch(`${server}/v1/meshes`, { method: "POST", body: square(height) });
    return (await told<Stored>(answer, 200, 201)).id;
  }));
  const pair: ByIds = { a: ids[0]!, b: ids[1]!, options: { gate: { max_distance: 3 } } };
  const headers = { "Content-Type": "application/json", Prefer: "respond-async" };
  const accepted = await fetch(`${server}/v1/comparisons`, { method: "POST", headers, body: JSON.stringify(pair) });
  let job = await told<Create["responses"][202]["content"]["application/json"]>(accepted, 202);
  while (job.state === "queued" || job.state === "running") {
    await new Promise((resolve) => setTimeout(resolve, 20));
    job = await told<Job>(await fetch(server + accepted.headers.get("Location")), 200);
  }
  if (!job.result) throw new Error(JSON.stringify(job));
  check(job.result);
}

await fromFiles();
await asJob();
