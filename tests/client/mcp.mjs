// A session with `meshgauge mcp` by the official client of the Model Context Protocol: node mcp.mjs BINARY
//
// The client itself holds what a tool finds against its schema. It waits for what it asks, so nothing depends on time.
import assert from "node:assert/strict";
import { mkdtemp, rm, symlink, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { Client } from "@modelcontextprotocol/sdk/client/index.js";
import { StdioClientTransport } from "@modelcontextprotocol/sdk/client/stdio.js";
import { ErrorCode, McpError } from "@modelcontextprotocol/sdk/types.js";

const MEGABYTE = 1 << 20;
const patient = { timeout: 300_000 };

// The unit square at this height in n * n squares.
function grid(n, height) {
  const lines = [];
  for (let y = 0; y <= n; ++y) for (let x = 0; x <= n; ++x) lines.push(`v ${x / n} ${y / n} ${height}`);
  for (let y = 0; y < n; ++y) {
    for (let x = 0; x < n; ++x) {
      const a = y * (n + 1) + x + 1;
      lines.push(`f ${a} ${a + 1} ${a + n + 2}`, `f ${a} ${a + n + 2} ${a + n + 1}`);
    }
  }
  return lines.join("\n") + "\n";
}

const inline = (text) => ({ name: "x.obj", base64: Buffer.from(text).toString("base64") });
const path = (name) => ({ path: name });

async function everyTool(client) {
  assert.equal(client.getServerVersion().name, "meshgauge");
  assert.ok(client.getInstructions().includes("compare_meshes"));
  const { tools } = await client.listTools();
  assert.deepEqual(tools.map((tool) => tool.name), ["compare_meshes", "inspect_mesh", "check_gates"]);
  await client.ping();

  const compared = await client.callTool(
    { name: "compare_meshes", arguments: { a: path("raised.obj"), b: path("flat.obj"), options: { max_distance: "1 mm" } } });
  assert.equal(compared.structuredContent.verdict, "fail");
  assert.equal(compared.structuredContent.criteria[0].verdict, "fail");
  const [text, json, image] = compared.content;
  assert.match(text.text, /^fail: the distance is at least /);
  assert.deepEqual(JSON.parse(json.text), compared.structuredContent);
  assert.equal(image.mimeType, "image/png");
  assert.ok(Buffer.from(image.data, "base64").subarray(1, 4).equals(Buffer.from("PNG")));

  const inspected = await client.callTool({ name: "inspect_mesh", arguments: { mesh: path("flat.obj"), unit: "mm" } });
  assert.equal(inspected.structuredContent.triangles, 2);
  assert.equal(inspected.structuredContent.topology.watertight, false);

  const told = [];
  const gates = await client.callTool({ name: "check_gates", arguments: {} }, undefined,
    { ...patient, onprogress: (progress) => told.push(progress) });
  assert.equal(gates.structuredContent.verdict, "fail");
  assert.deepEqual(gates.structuredContent.gates.map((gate) => gate.verdict), ["pass", "fail"]);
  // The client forgets what is told in the same piece of its input as the answer.
  assert.deepEqual(told.map((progress) => progress.progress), [1, 2].slice(0, told.length));
}

async function mistakes(client) {
  await assert.rejects(client.callTool({ name: "measure", arguments: {} }),
    (error) => error instanceof McpError && error.code === ErrorCode.InvalidParams);
  const refused = await client.callTool({ name: "compare_meshes", arguments: { a: path("flat.obj"), options: { max_distance: "far" } } });
  assert.equal(refused.isError, true);
  assert.match(refused.content[0].text, /^\/b is missing/);
  assert.match(refused.content[0].text, /^\/options\/max_distance /m);
  for (const name of ["../secret.obj", "link.obj", "/etc/passwd"]) {
    const outside = await client.callTool({ name: "inspect_mesh", arguments: { mesh: path(name) } });
    assert.equal(outside.isError, true, name);
  }
}

async function limits(client) {
  const large = await client.callTool({ name: "inspect_mesh", arguments: { mesh: inline(" ".repeat(17 * MEGABYTE)) } }, undefined, patient);
  assert.equal(large.isError, true);
  assert.match(large.content[0].text, /has more than 16777216 bytes/);
  const larger = { name: "inspect_mesh", arguments: { mesh: { base64: "A".repeat(48 * MEGABYTE) } } };
  await assert.rejects(client.callTool(larger, undefined, patient),
    (error) => error instanceof McpError && error.code === ErrorCode.InvalidRequest);
}

// Cancels a comparison that runs for at least ten seconds, when it is known to run.
async function cancelled(client) {
  const abort = new AbortController();
  const options = { strategy: "four_point", tolerance: { absolute: 0 }, timeout: 100 };
  const call = { name: "compare_meshes", arguments: { a: path("slow_a.obj"), b: path("slow_b.obj"), options } };
  let ended;
  await new Promise((resolve) => {
    ended = client.callTool(call, undefined, { ...patient, signal: abort.signal, onprogress: () => resolve() })
      .then(() => "ended", () => "cancelled");
    ended.then(resolve);
  });
  abort.abort("test");
  assert.equal(await ended, "cancelled");
  await client.ping();
}

async function twentyAtOnce(client) {
  const calls = [];
  for (let i = 1; i <= 20; ++i) {
    calls.push(client.callTool({ name: "compare_meshes", arguments: {
      a: inline(grid(12, i)), b: inline(grid(12, 0)), options: { max_distance: 10.5 }, picture: false } }, undefined, patient));
  }
  const verdicts = (await Promise.all(calls)).map((result) => result.structuredContent.verdict);
  assert.deepEqual(verdicts, verdicts.map((_, i) => (i + 1 <= 10.5 ? "pass" : "fail")));
}

async function session(program, folder) {
  const client = new Client({ name: "meshgauge-test", version: "1.0.0" });
  const transport = new StdioClientTransport(
    { command: program, args: ["mcp", "--root", folder], cwd: tmpdir(), env: process.env, stderr: "ignore" });
  await client.connect(transport);
  try {
    await everyTool(client);
    await mistakes(client);
    await limits(client);
    await twentyAtOnce(client);
    await cancelled(client);
  } finally {
    await client.close();
  }
}

const folder = await mkdtemp(join(tmpdir(), "meshgauge-mcp-"));
try {
  const files = {
    "flat.obj": grid(1, 0), "copy.obj": grid(1, 0), "raised.obj": grid(1, 2), "slow_a.obj": grid(40, 0), "slow_b.obj": grid(43, 0),
    "gates.yaml": "version: 1\ndefaults: {max_distance: 1}\ngates:\n- {name: same, candidate: copy.obj, baseline: flat.obj}\n"
      + "- {name: raised, candidate: raised.obj, baseline: flat.obj}\n",
  };
  for (const [name, text] of Object.entries(files)) await writeFile(join(folder, name), text);
  await symlink("flat.obj", join(folder, "link.obj"));
  await session(process.argv[2], folder);
} finally {
  await rm(folder, { recursive: true });
}
console.log("every tool, limits, twenty calls at once and cancellation: as they should be");
