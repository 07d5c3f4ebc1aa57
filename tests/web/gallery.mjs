// The pictures of the README and docs: screenshots of the real page, report and comment, on meshes of the
// project's own. ./dev gallery [NAME...]
//
// Writes docs/gallery/NAME.png, 1200 pixels wide and with 256 colours at most (pngquant), so that each stays small. What they
// show is the same each time but for what a clock says: times in ms, and how far an interval has shrunk.
import { execFileSync, spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { launch, Tab } from "./browser/browser.mjs";
import { ply, stl, written, xyz } from "./browser/meshes.mjs";
import { Walk } from "./browser/page.mjs";
import { json, stored } from "./browser/batches.mjs";
import { nightly } from "./gallery_batch.mjs";
import { commented } from "./gallery_comment.mjs";
import { asked, binary, root, startService } from "./browser/service.mjs";
import { drawn, ground, holed, moved, printed } from "./gallery_meshes.mjs";

const to = join(root, "docs/gallery"), most = 250_000;
const folder = mkdtempSync(join(tmpdir(), "meshgauge-gallery-"));
const files = written(folder, { "gear_printed.stl": stl(printed()), "gear.stl": stl(drawn()), "ground.ply": ply(ground(1)), "scan.ply": ply(ground(2)), "gear_scan.xyz": xyz(printed()), "gear_moved.stl": stl(moved()), "gear_holed.stl": stl(holed()) });

const gear = { a: files["gear_printed.stl"], b: files["gear.stl"], limit: "0.3", units: "mm", tolerance: ["relative", "1"] };
const window = { viewport: { width: 1200, height: 1200 }, reducedMotion: "reduce" };

const pictures = {
  async result() {
    const walk = await open({ viewport: { width: 1200, height: 1640 } });
    await measured(walk, gear);
    await save("result", await walk.page.screenshot());
    return walk;
  },
  async witness() {
    const walk = await open({ colorScheme: "dark" });
    const viewer = await measured(walk, gear);
    await viewer.evaluate((host) => host.viewer.flyToWitness(0));
    await viewer.evaluate((host) => {
      const { position, target } = host.viewer.camera(); // with more of the surroundings than the flight leaves
      host.viewer.setCamera({ position: target.map((x, k) => x + 4 * (position[k] - x)) });
    });
    await walk.still();
    await save("witness", await viewer.screenshot());
    return walk;
  },
  async side_by_side() {
    const walk = await open();
    const viewer = await measured(walk, gear);
    await walk.press("Side by side");
    await walk.still();
    await save("side_by_side", await viewer.screenshot());
    return walk;
  },
  async cloud() {
    const walk = await open();
    const viewer = await measured(walk, { ...gear, a: files["gear_scan.xyz"], direction: "a_to_b" });
    await save("cloud", await viewer.screenshot());
    return walk;
  },
  async regions() {
    const regions = [
      { name: "bore", box: { min: [-10, -10, -6], max: [10, 10, 6] }, max_distance: 0.02 },
      { name: "worn tooth", sphere: { centre: [20.4, -24.7, 0], radius: 8 }, max_distance: 1 },
    ];
    const options = { gate: { max_distance: 0.3, units: "mm", narrow: true }, regions };
    const [a, b] = [await stored(service, stl(printed())), await stored(service, stl(drawn()))];
    const { view } = await (await asked(service, "/v1/comparisons", json({ a, b, options }))).json();
    const walk = await open({ viewport: { width: 1200, height: 880 } });
    await walk.tab.go(view);
    await walk.measured();
    await walk.still();
    await save("regions", await walk.page.screenshot());
    return walk;
  },
  async expected() {
    const expect = { watertight: true, triangles: { max: 20000 }, degenerate: 0, components: 1, volume: { within: 0.01 } };
    const walk = await open({ viewport: { width: 1200, height: 1020 } });
    await measured(walk, { ...gear, a: files["gear_holed.stl"], limit: "1", further: JSON.stringify({ expect }) });
    await save("expected", await walk.page.screenshot());
    return walk;
  },
  async zone() {
    const walk = await open({ viewport: { width: 1200, height: 800 } });
    await measured(walk, { ...gear, limit: "", inside: "0.5", outside: "0.7" });
    await save("zone", await walk.page.screenshot());
    return walk;
  },
  async sides() {
    const walk = await open();
    const viewer = await measured(walk, { ...gear, limit: "", inside: "0.5", outside: "0.7" });
    await save("sides", await viewer.screenshot());
    return walk;
  },
  async alignment() {
    const walk = await open({ viewport: { width: 1200, height: 1000 } });
    await measured(walk, { ...gear, a: files["gear_moved.stl"], align: true });
    await save("alignment", await walk.page.screenshot());
    return walk;
  },
  // Of the HTML report: a hole in the hub, and more triangles than the gate expects.
  async expectations() {
    checked("gear_holed.stl", "1 mm", "expect: {watertight: true, triangles: {max: 20000}, degenerate: 0, components: 1, volume: {within: 1 %}}");
    return cardUpTo("expectations", "table");
  },
  // Of the HTML report: each print is worn more than those before.
  async history() {
    for (let run = 0; run < 16; ++run) {
      const wear = 0.032 * run + 0.03 * Math.sin(2.4 * run);
      writeFileSync(join(folder, "gear_worn.stl"), stl(printed(([x, y, z]) => [x - 0.64 * wear, y + 0.77 * wear, z])));
      checked("gear_worn.stl", "1.5 mm", "", "--history", "history.jsonl");
    }
    return cardUpTo("history", "svg.history");
  },
  // The action's comment on a pull request, at about the width that it has on GitHub.
  async comment() {
    const context = await browser.newContext({ viewport: { width: 800, height: 1400 }, deviceScaleFactor: 1.5 });
    const page = await context.newPage();
    await page.goto(commented(folder));
    await page.locator("article img").waitFor();
    await save("comment", await page.locator("article").screenshot());
    return { tab: page };
  },
  // The page and the report on a phone, light and dark.
  async phone() {
    const screen = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 1 }, shots = [];
    for (const colorScheme of ["light", "dark"]) {
      const walk = await open({ ...screen, colorScheme });
      await measured(walk, { ...gear, inside: "0.5", outside: "0.7" });
      shots.push(await walk.page.screenshot());
      await walk.tab.close();
    }
    several();
    const page = await (await browser.newContext({ ...screen, colorScheme: "dark" })).newPage();
    await page.goto(pathToFileURL(join(folder, "report.html")).href);
    shots.push(await page.screenshot());
    await page.close();
    return besideEachOther("phone", shots);
  },
  // The table of the HTML report, in the dark.
  async table() {
    several();
    const page = await (await browser.newContext({ viewport: { width: 1200, height: 620 }, colorScheme: "dark" })).newPage();
    await page.goto(pathToFileURL(join(folder, "report.html")).href);
    await save("table", await page.screenshot());
    return { tab: page };
  },
  async areas() {
    const [a, b] = [await stored(service, stl(printed())), await stored(service, stl(drawn()))];
    const options = { direction: "a_to_b", areas: { beyond: [0.05, 0.1, 0.3], quantiles: [0.5, 0.95, 0.99], mean: true } };
    const { view } = await (await asked(service, "/v1/comparisons", json({ a, b, options }))).json();
    const walk = await open({ viewport: { width: 1200, height: 2400 } });
    await walk.tab.go(view);
    await walk.measured();
    await walk.still();
    await save("areas", await walk.page.locator(".card", { has: walk.page.getByRole("heading", { name: "Both directions" }) }).last().screenshot());
    return walk;
  },
  async batch() {
    const { view } = await nightly(service);
    const walk = await open({ viewport: { width: 1200, height: 1016 } });
    await walk.tab.go(view);
    await walk.page.locator(".rows tbody tr").first().waitFor();
    await save("batch", await walk.page.screenshot());
    return walk;
  },
  async running() {
    const walk = await open({ colorScheme: "dark", viewport: { width: 1200, height: 760 } });
    await walk.fill({ a: files["scan.ply"], b: files["ground.ply"], limit: "0.01303", units: "m", tolerance: ["relative", "1e-4"] });
    await walk.measure();
    await walk.page.waitForFunction(() => parseFloat(document.querySelector("#run-view .reading span:last-child")?.textContent ?? "") < 0.2);
    await save("running", await walk.page.screenshot());
    return walk;
  },
};

const browser = await launch(), service = await startService();

async function open(how = {}) {
  return Walk.begin(await Tab.open(browser, service, { ...window, ...how }));
}

// Runs a gate of the drawn gear, which ends without an error, and leaves report.html.
function checked(candidate, limit, more, ...flags) {
  writeFileSync(join(folder, "gates.yaml"), `version: 1\ngates:\n  - name: gear\n    candidate: ${candidate}\n    baseline: gear.stl\n    max_distance: ${limit}\n    ${more}\n`);
  const { status } = spawnSync(binary, ["check", "gates.yaml", "--html", "report.html", ...flags], { cwd: folder });
  if (status > 1) throw new Error(`check ended with ${status}`);
}

// Gates with several limits, one of which fails, and leaves report.html.
function several() {
  const gates = [
    "{name: gear, candidate: gear_printed.stl, baseline: gear.stl, max_distance: 1 mm, zone: [-0.5 mm, 0.7 mm]}",
    "{name: gear with a worn tooth, candidate: gear_printed.stl, baseline: gear.stl, max_distance: 0.3 mm, regions: [{name: bore, box: {min: [-10, -10, -6], max: [10, 10, 6]}, max_distance: 0.05 mm}]}",
    "{name: gear without its bore, candidate: gear_holed.stl, baseline: gear.stl, max_distance: 1 mm, expect: {watertight: true, components: 1}}",
    "{name: gear as it lay, candidate: gear_moved.stl, baseline: gear.stl, max_distance: 1 mm, align: rigid}",
  ];
  writeFileSync(join(folder, "gates.yaml"), `version: 1\ngates:\n${gates.map((gate) => `  - ${gate}\n`).join("")}`);
  const { status } = spawnSync(binary, ["check", "gates.yaml", "--html", "report.html"], { cwd: folder });
  if (status > 1) throw new Error(`check ended with ${status}`);
}

async function besideEachOther(name, shots) {
  const page = await (await browser.newContext({ viewport: { width: 1200, height: 844 } })).newPage();
  const images = shots.map((bytes) => `<img src="data:image/png;base64,${bytes.toString("base64")}">`).join("");
  await page.setContent(`<body style="margin:0;display:flex;gap:15px;background:#888">${images}</body>`);
  await page.waitForFunction(() => [...document.images].every((image) => image.complete));
  await save(name, await page.screenshot());
  return { tab: page };
}

// Of the report's gate: from its top to the end of the first such element.
async function cardUpTo(name, selector) {
  const page = await (await browser.newContext({ viewport: { width: 1200, height: 2000 } })).newPage();
  await page.goto(pathToFileURL(join(folder, "report.html")).href);
  const card = page.locator("article.gate"), box = await card.boundingBox(), end = await card.locator(selector).first().boundingBox();
  await save(name, await page.screenshot({ clip: { ...box, height: end.y + end.height + 4 - box.y } }));
  return { tab: page };
}

async function measured(walk, order) {
  await walk.fill(order);
  await walk.measure();
  await walk.measured();
  return walk.viewer();
}

async function save(name, bytes) {
  mkdirSync(to, { recursive: true });
  const path = join(to, `${name}.png`);
  writeFileSync(path, bytes);
  execFileSync("pngquant", ["--force", "--skip-if-larger", "--speed", "1", "--strip", "--output", path, "256", path]);
  const { size } = statSync(path);
  console.log(`docs/gallery/${name}.png: ${size} bytes`);
  if (size > most) process.exitCode = 1;
}

for (const [name, take] of Object.entries(pictures)) {
  if (process.argv.length > 2 && !process.argv.includes(name)) continue;
  const walk = await take();
  await walk.tab.close();
}
await browser.close();
await service.stop();
rmSync(folder, { recursive: true });
