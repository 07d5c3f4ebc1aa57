// Actions of a user on the page, by the accessible names of its parts.
import assert from "node:assert/strict";

import { asked } from "./service.mjs";

export const patience = 200_000; // ms, beyond the service's own time: two tests at once draw by software on few processors

export class Walk {
  constructor(tab) {
    this.tab = tab;
    this.page = tab.page;
    this.page.setDefaultTimeout(patience);
  }

  static async begin(tab) {
    const walk = new Walk(tab);
    await tab.go("/");
    await walk.page.locator("#form-view").waitFor();
    return walk;
  }

  // `limit` as typed; `tolerance: ["diagonal", "1e-4"]`; files are paths, or as Playwright takes them.
  async fill({ a, b, limit, units, tolerance, direction, strategy, timeout, threads, align, inside, outside, further }) {
    const { page } = this;
    if (a) await page.locator("#file-a").setInputFiles(a);
    if (b) await page.locator("#file-b").setInputFiles(b);
    if (limit !== undefined) await page.locator("#limit").fill(limit);
    if (inside !== undefined) await page.locator("#inside").fill(inside);
    if (outside !== undefined) await page.locator("#outside").fill(outside);
    if (units !== undefined) await page.locator("#units").selectOption(units);
    if (direction) await page.locator(`[name=direction][value=${direction}]`).check();
    if (tolerance) {
      await page.locator("#toleranceKind").selectOption(tolerance[0]);
      await page.locator("#tolerance").fill(tolerance[1]);
    }
    if (strategy || timeout || threads || align || further) await page.locator("#more").evaluate((more) => (more.open = true));
    if (strategy) await page.locator("#strategy").selectOption(strategy);
    if (timeout) await page.locator("#timeout").fill(timeout);
    if (threads) await page.locator("#threads").fill(threads);
    if (align) await page.locator("#align").check();
    if (further) await page.locator("#further").fill(further);
  }

  // By the keyboard: what loads above a button moves it, and a press of the mouse would begin on it and end beside it.
  press(name) {
    return this.page.getByRole("button", { name, exact: true, disabled: false }).press("Enter");
  }

  // By the mouse, where nothing moves any more.
  click(name) {
    return this.page.getByRole("button", { name, exact: true }).click();
  }

  async newPair() {
    await this.page.getByRole("link", { name: "New pair" }).press("Enter");
    await this.page.locator("#form-view:not([hidden])").waitFor();
  }

  measure() {
    return this.page.locator("#measure").click();
  }

  async measured() {
    await this.page.locator("#result-view").waitFor();
  }

  // Waits until the search has an interval: a comparison that is cancelled earlier ends without a result.
  searching() {
    return this.reads("#run-view .reading", /\d\s*to\s*\d/);
  }

  // The comparison's id, from the address.
  id() {
    const id = /\/c\/([0-9a-f]{32})$/.exec(new URL(this.page.url()).pathname)?.[1];
    if (!id) throw new Error(`${this.page.url()} names no comparison`);
    return id;
  }

  async job() {
    return (await asked(this.tab.service, `/v1/comparisons/${this.id()}`)).json();
  }

  text(selector) {
    return this.page.locator(selector).innerText();
  }

  // Waits until the text of the element is as expected.
  async reads(selector, pattern) {
    const reads = ([each, source, flags]) => new RegExp(source, flags).test(document.querySelector(each)?.innerText ?? "");
    const end = this.page.waitForFunction(reads, [selector, pattern.source, pattern.flags]);
    await end.catch(async () => assert.match(await this.text(selector), pattern));
  }

  // Waits until the element of these words has the focus.
  focused(words) {
    return this.page.waitForFunction((each) => document.activeElement.textContent === each, words);
  }

  // The viewer's element, when it has been built and its first picture drawn.
  async viewer() {
    await this.page.waitForFunction(() => [...document.querySelectorAll("*")].some((each) => each.viewer), undefined, { timeout: patience });
    const handle = await this.page.evaluateHandle(() => [...document.querySelectorAll("*")].find((each) => each.viewer));
    await this.still();
    return handle.asElement();
  }

  // Waits until nothing moves any more and the picture, if any, is drawn in full.
  async still() {
    await this.page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    await this.page.evaluate(() => [...document.querySelectorAll("*")].find((each) => each.viewer)?.viewer.settled());
  }
}

// Records, from now on and at each change, what the page shows of the interval while it runs: its two numbers, and the
// corners of the drawn band.
export function watchInterval(page) {
  return page.evaluate(() => {
    globalThis.seen = [];
    const look = () => {
      const reading = [...document.querySelectorAll("#run-view .reading span")].map((each) => each.textContent);
      const points = document.querySelector("#run-view .band")?.getAttribute("points") ?? "";
      const last = globalThis.seen.at(-1);
      const text = reading.join(" ");
      if (text !== "" && (!last || last.text !== text || last.points !== points)) globalThis.seen.push({ text, points });
    };
    globalThis.looking = new MutationObserver(look);
    globalThis.looking.observe(document.querySelector("#run-view"), { subtree: true, childList: true, characterData: true, attributes: true });
  });
}

// [{text, lower, upper, corners}] of what was seen, in order; upper is Infinity where it is not known.
export async function seenInterval(page) {
  const seen = await page.evaluate(() => (globalThis.looking.disconnect(), globalThis.seen));
  return seen.map(({ text, points }) => {
    const [lower, upper] = text.split(" to ").map((part) => parseFloat(part));
    return { text, lower: lower || 0, upper: Number.isFinite(upper) ? upper : Infinity, corners: points === "" ? 0 : points.split(" ").length };
  });
}
