// Debian's Chromium, and tabs that record their requests and their messages.
import assert from "node:assert/strict";
import { accessSync, constants, mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { delimiter, join } from "node:path";
import { chromium } from "playwright-core";
import { root } from "./service.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const shots = process.env.MESHGAUGE_SCREENSHOTS ?? join(root, "build/tests/web/screenshots");

// WebGL by software, and no request of the browser's own.
const flags = ["--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-quic",
  "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

// Only the viewer's canvas is then drawn by OpenGL, which costs less than all of the page without a graphics card.
export const plainPage = "--disable-gpu-compositing";

// With plainPage the browser reads each picture of the canvas back, and says so.
const readBack = /GPU stall due to ReadPixels/;

const usual = { width: 840, height: 700 };

function executable() {
  for (const name of ["chromium", "chromium-browser", "google-chrome"])
    for (const folder of process.env.PATH.split(delimiter)) {
      const path = join(folder, name);
      try {
        accessSync(path, constants.X_OK);
        return path;
      } catch {
        continue;
      }
    }
  return null;
}

// ctest takes this exit code as skipped: there is no browser.
export async function launch(...more) {
  const executablePath = executable();
  if (executablePath) return chromium.launch({ executablePath, args: [...flags, ...more] });
  console.log("SKIP: there is no chromium");
  process.exit(77);
}

// A tab of a browser context of its own: its storage is empty. `service` is the only origin it may talk to; any other
// request is refused and counted. The page scrolls at once: while it scrolls smoothly, a press of the mouse begins on a button
// and ends beside it.
export class Tab {
  static async open(browser, service, { bypassCSP = false, reducedMotion = "reduce", ...how } = {}) {
    const context = await browser.newContext({ viewport: usual, bypassCSP, reducedMotion, ...how });
    const tab = new Tab();
    Object.assign(tab, { context, service });
    tab.#forget();
    tab.page = await context.newPage();
    await context.route("**/*", (route) => tab.#let(route));
    tab.page.on("console", (line) => tab.#hear(line));
    tab.page.on("pageerror", (error) => tab.said.push(String(error.stack ?? error)));
    tab.page.on("response", (answer) => tab.#note(answer));
    return tab;
  }

  #forget() {
    Object.assign(this, { foreign: [], requests: [], said: [], stalls: [], policies: new Map() });
  }

  // As a new tab: without routes, storage and records. A script that was added to all of its pages stays.
  async renew() {
    await this.page.unrouteAll({ behavior: "ignoreErrors" });
    await this.context.setOffline(false);
    await this.page.setViewportSize(usual);
    await this.go("/healthz");
    await this.page.evaluate(() => sessionStorage.clear());
    this.#forget();
  }

  async #let(route) {
    const url = route.request().url();
    this.requests.push(`${route.request().method()} ${url}`);
    const isForeign = ![this.service.origin + "/", "blob:", "data:"].some((start) => url.startsWith(start));
    if (isForeign) this.foreign.push(url);
    // A route of a test that is removed while it answers leaves the request to this one, too: it has its answer by then.
    return (isForeign ? route.abort() : route.continue()).catch((error) => {
      if (!/already handled/.test(String(error))) throw error;
    });
  }

  #hear(line) {
    const list = readBack.test(line.text()) ? this.stalls : this.said;
    if (["error", "warning"].includes(line.type())) list.push(`${line.text()} (${line.location().url})`);
  }

  #note(answer) {
    if (answer.request().resourceType() === "document")
      this.policies.set(answer.url(), answer.headers()["content-security-policy"] ?? "");
  }

  go(path) {
    return this.page.goto(this.service.origin + path);
  }

  // Asserts what must hold after every walk through the page. `expected`: patterns of lines that the browser itself writes, as
  // for an answer of 404.
  assertClean({ expected = [] } = {}) {
    assert.deepEqual(this.foreign, [], "requests to other origins");
    const said = this.said.filter((line) => !expected.some((pattern) => pattern.test(line)));
    assert.deepEqual(said, [], "errors and warnings in the console");
    assert.ok(this.policies.size > 0, "no document was loaded");
    for (const [url, policy] of this.policies) {
      assert.match(policy, /default-src 'none'/, url);
      assert.doesNotMatch(policy, /unsafe-inline|unsafe-eval|unsafe-hashes|\*|https?:/, url);
    }
  }

  // A picture of the window, kept as NAME.png; with `whole` of all of the page. Gives the bytes.
  shot(name, { whole = false, ...how } = {}) {
    mkdirSync(shots, { recursive: true });
    return this.page.screenshot({ path: join(shots, `${name}.png`), fullPage: whole, ...how });
  }

  // Requests that are under way do not matter any more, nor what becomes of their routes.
  async close() {
    await this.page.unrouteAll({ behavior: "ignoreErrors" });
    await this.context.unrouteAll({ behavior: "ignoreErrors" });
    await this.context.close();
  }
}

// Serious and critical findings of axe, as lines. The tab must have been opened with bypassCSP, which lets axe in.
export async function faults(tab) {
  if (!(await tab.page.evaluate(() => "axe" in globalThis))) await tab.page.evaluate(axe);
  const result = await tab.page.evaluate(() => globalThis.axe.run({ resultTypes: ["violations"] }));
  return result.violations
    .filter((each) => ["serious", "critical"].includes(each.impact))
    .flatMap((each) => each.nodes.map((node) => `${each.id}: ${node.html.slice(0, 200)} ${node.failureSummary ?? ""}`));
}
