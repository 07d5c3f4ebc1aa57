// Opens a report from disk in a browser, takes screenshots and prints what it found as JSON.
// look.mjs BROWSER PAGE FOLDER LOOK ...: axe checks these looks.
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { join } from "node:path";
import { readFileSync } from "node:fs";
import { chromium } from "playwright-core";

const [, , executablePath, page, folder, ...byAxe] = process.argv;
const axeSource = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const address = pathToFileURL(page).href;
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });

// bypassCSP lets axe run. Every request except that for the page itself is refused and counted.
async function open({ width, colorScheme = "light", bypassCSP = false }) {
  const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme, bypassCSP, offline: true });
  const tab = await context.newPage();
  const asked = [], console_ = [];
  await tab.route("**/*", (route) => {
    const url = route.request().url();
    if (url === address || url.startsWith("data:")) return route.continue();
    asked.push(url);
    return route.abort();
  });
  tab.on("console", (message) => console_.push(message.text()));
  tab.on("pageerror", (error) => console_.push(String(error)));
  await tab.goto(address);
  return { tab, context, asked, console: console_ };
}

// The picture is of the whole page or of its beginning.
async function look(name, how, { media, fullPage = false } = {}) {
  const { tab, context, asked, console: lines } = await open(how);
  if (media) await tab.emulateMedia({ media });
  const width = await tab.evaluate(() => document.documentElement.scrollWidth);
  await tab.screenshot({ path: join(folder, `${name}.png`), fullPage });
  const broken = await tab.evaluate(wordsBroken);
  await context.close();
  const checked = byAxe.includes(name), findings = checked ? await serious(how) : [];
  return { name, requests: asked.length, asked, width, room: how.width, checked, findings, broken, console: lines };
}

// The words of the table's names that end on another line than they begin, unless they are very long.
function wordsBroken() {
  const broken = [], range = document.createRange();
  for (const cell of document.querySelectorAll(".index th[scope=row]")) {
    const walker = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      for (const { 0: word, index } of walker.currentNode.data.matchAll(/\S{1,20}(?!\S)/g)) {
        range.setStart(walker.currentNode, index);
        range.setEnd(walker.currentNode, index + word.length);
        const lines = new Set([...range.getClientRects()].map((rect) => Math.round(rect.top)));
        if (lines.size > 1 && (index === 0 || /\s/.test(walker.currentNode.data[index - 1]))) broken.push(word);
      }
    }
  }
  return broken;
}

// The dark differs from the light by its colours alone.
async function serious(how) {
  const { tab, context } = await open({ ...how, bypassCSP: true });
  await tab.evaluate(() => document.querySelectorAll("details").forEach((each) => (each.open = true)));
  await tab.evaluate(axeSource);
  const rules = how.colorScheme === "dark" ? { runOnly: ["color-contrast"] } : {};
  const result = await tab.evaluate((more) => globalThis.axe.run({ resultTypes: ["violations"], selectors: false, ...more }), rules);
  await context.close();
  return result.violations
    .filter((each) => ["serious", "critical"].includes(each.impact))
    .map((each) => `${each.id}: ${each.nodes.length} times, as ${each.nodes[0].html.slice(0, 200)}`);
}

// Each choice shows its own gates, in the table and as cards, and no other.
async function filter(tab) {
  const wrong = [];
  for (const choice of await tab.locator("input[name=show]").all()) {
    const id = await choice.getAttribute("id");
    await tab.locator(`label[for=${id}]`).click();
    const shown = await tab.locator(".gate").evaluateAll((all) => all.filter((e) => e.checkVisibility()).map((e) => e.className));
    const kind = id.replace("show-", "");
    const all = await tab.locator(kind === "all" ? ".gate" : `.gate.${kind}`).count();
    if (shown.length !== all || (kind !== "all" && shown.some((name) => name.replace(" criterion", "") !== `gate ${kind}`)))
      wrong.push(`${id} shows ${shown.length} of ${all}: ${shown}`);
  }
  return wrong;
}

// All pictures are decoded and have their size and words.
async function pictures(tab) {
  const wrong = await tab.locator("img").evaluateAll((all) =>
    all.filter((e) => e.naturalWidth !== e.width && e.naturalWidth !== Number(e.getAttribute("width"))).map((e) => e.alt));
  const count = await tab.locator("img").count();
  return count > 0 ? wrong : ["there is none"];
}

const views = [
  await look("light", { width: 1280 }, { fullPage: true }),
  await look("dark", { width: 1280, colorScheme: "dark" }),
  await look("narrow", { width: 360 }),
  await look("print", { width: 794 }, { media: "print" }), // axe sees the screen alone
];
const { tab } = await open({ width: 1280 });
console.log(JSON.stringify({ views, pictures: await pictures(tab), filter: await filter(tab) }));
await browser.close();
