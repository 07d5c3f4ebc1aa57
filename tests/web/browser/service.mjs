// The built service, on a port and in a data directory of its own.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

export const root = resolve(fileURLToPath(import.meta.url), "../../../..");
export const binary = process.env.MESHGAUGE_BINARY ?? join(root, "build/meshgauge");

// Settings of the environment must not reach the tested service. A slow machine, and a sanitizer, need more time.
const environment = {
  ...Object.fromEntries(Object.entries(process.env).filter(([name]) => !name.startsWith("MESHGAUGE_"))),
  MESHGAUGE_DEFAULT_TIMEOUT_MS: "180000",
};

// {origin, log: its lines, stop()}. `flags` as those of `meshgauge serve`.
export async function startService(...flags) {
  const folder = mkdtempSync(join(tmpdir(), "meshgauge-browser-"));
  const child = spawn(binary, ["serve", "--port", "0", "--data-dir", join(folder, "data"), ...flags],
    { env: environment, stdio: ["ignore", "ignore", "pipe"] });
  const end = () => child.kill("SIGKILL");
  process.once("exit", end); // a test that fails half-way must not leave it behind
  const lines = createInterface({ input: child.stderr }), log = [];
  const first = await new Promise((done, fail) => {
    child.once("error", (error) => fail(new Error(`${binary}: ${error.message}`)));
    child.once("exit", (code) => fail(new Error(`${binary} ended with ${code}: ${log.join("\n")}`)));
    lines.on("line", (line) => (log.push(line), done(line)));
  });
  const started = JSON.parse(first);
  if (started.event !== "listening") throw new Error(`${binary} says ${first}`);
  const stop = async () => {
    child.removeAllListeners("exit");
    const code = await new Promise((done) => (child.once("exit", done), child.kill("SIGTERM")));
    process.removeListener("exit", end);
    rmSync(folder, { recursive: true, force: true });
    if (code !== 0) throw new Error(`the service ended with ${code}: ${log.slice(-5).join("\n")}`);
  };
  return { origin: `http://${started.detail}`, folder, log, stop };
}

// The answer to a request that the test sends itself, to check the page against it.
export async function asked(service, path, init) {
  const answer = await fetch(service.origin + path, init);
  if (!answer.ok) throw new Error(`${path}: ${answer.status} ${await answer.text()}`);
  return answer;
}
