// How long frames take while somebody turns, zooms, cuts and brushes a large pair, and what memory that costs. Not a test of
// ctest: times belong to a machine that does nothing else.
//
//   node tests/web/browser/frames.mjs [WIDTH HEIGHT [A B]]     by default 960 600 and the corpus' pair of a million triangles,
//                                                              or one that is made where there is no corpus
//
// Prints the figures and ends with 1 when a frame takes longer than 200 ms.
import { tmpdir } from "node:os";
import { mkdtempSync, rmSync } from "node:fs";
import { join } from "node:path";
import { launch, Tab } from "./browser.mjs";
import { heap, processes } from "./memory.mjs";
import { corpus, dented, ply, sphere, written } from "./meshes.mjs";
import { Walk } from "./page.mjs";
import { startService } from "./service.mjs";

const mostMs = 200;

export async function largePair(folder) {
  const [a, b] = ["armadillo_voxel1M.ply.gz", "armadillo_voxel1M_half.ply.gz"].map(corpus);
  if (a && b) return { a, b, name: "armadillo, 1,067,528 and 533,764 triangles" };
  const made = written(folder, { "sphere.ply": ply(sphere(500)), "dented.ply": ply(dented(370)) });
  return { a: made["sphere.ply"], b: made["dented.ply"], name: "a sphere and one with a dent, 1,000,000 and 547,600 triangles" };
}

// From the last frame to each next one, and how long each task kept the page.
function startClock(page) {
  return page.evaluate(() => {
    const clock = (globalThis.clock = { frames: [], tasks: [], run: true });
    let last = performance.now();
    const tick = (now) => {
      clock.frames.push(now - last);
      last = now;
      if (clock.run) requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
    clock.observer = new PerformanceObserver((list) => clock.tasks.push(...list.getEntries().map((each) => each.duration)));
    clock.observer.observe({ entryTypes: ["longtask"] });
  });
}

async function stopClock(page, viewer) {
  const { frames, tasks } = await page.evaluate(() => {
    const { clock } = globalThis;
    clock.run = false;
    clock.observer.disconnect();
    return { frames: clock.frames, tasks: clock.tasks };
  });
  const drawn = await viewer.evaluate((host) => host.viewer.frameTimes());
  return { frames: summary(frames.slice(1)), tasks: summary(tasks), drawn: summary(drawn) };
}

function summary(times) {
  const sorted = [...times].sort((x, y) => x - y), at = (share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? 0;
  return { count: sorted.length, median: Math.round(at(0.5)), p95: Math.round(at(0.95)), longest: Math.round(sorted.at(-1) ?? 0) };
}

const gestures = {
  async turn(page, box) {
    await drag(page, box, 40, (share) => [0.3 + 0.4 * share, 0.5 + 0.2 * Math.sin(6 * share)]);
  },
  async zoom(page, box) {
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    for (let i = 0; i < 24; ++i) {
      await page.mouse.wheel(0, i < 12 ? -120 : 120);
      await page.waitForTimeout(30);
    }
  },
  async move(page, box) {
    await drag(page, box, 30, (share) => [0.5 + 0.2 * Math.sin(6 * share), 0.5 + 0.2 * Math.cos(6 * share)], "right");
  },
  async fly(page, box, viewer) {
    await viewer.evaluate((host) => host.viewer.flyToWitness(0));
  },
};

async function drag(page, box, steps, at, button = "left") {
  const to = (share) => at(share).map((part, k) => (k === 0 ? box.x + part * box.width : box.y + part * box.height));
  await page.mouse.move(...to(0));
  await page.mouse.down({ button });
  for (let i = 1; i <= steps; ++i) {
    await page.mouse.move(...to(i / steps));
    await page.waitForTimeout(16);
  }
  await page.mouse.up({ button });
}

async function main([width = 960, height = 600, ...files]) {
  const folder = mkdtempSync(join(tmpdir(), "meshgauge-frames-"));
  const service = await startService(), browser = await launch("--js-flags=--expose-gc", "--enable-precise-memory-info");
  const pair = files.length === 2 ? { a: files[0], b: files[1], name: files.join(" and ") } : await largePair(folder);
  const tab = await Tab.open(browser, service, { viewport: { width: Number(width), height: Number(height) } });
  const walk = await Walk.begin(tab), { page } = tab;
  console.log(`${pair.name}; window ${width} x ${height}, drawn by software`);
  console.log("before", await heap(page), await processes(browser));
  const begun = performance.now();
  await walk.fill({ a: pair.a, b: pair.b });
  await walk.measure();
  await walk.measured();
  console.log(`result after ${Math.round(performance.now() - begun)} ms`);
  await startClock(page);
  const viewer = await walk.viewer();
  console.log(`picture after ${Math.round(performance.now() - begun)} ms`, await stopClock(page, viewer));
  const longest = await interact(walk, viewer);
  console.log("after", await heap(page), await processes(browser));
  tab.assertClean({ expected: [/404.*\/v1\/meshes\//] }); // it was asked whether they are there
  await browser.close();
  await service.stop();
  rmSync(folder, { recursive: true });
  console.log(`longest frame ${longest} ms, at most ${mostMs} allowed`);
  process.exitCode = longest > mostMs ? 1 : 0;
}

async function interact(walk, viewer) {
  const { page } = walk, canvas = page.locator("canvas").first();
  let longest = 0;
  for (const [name, gesture] of Object.entries(gestures)) {
    await canvas.scrollIntoViewIfNeeded();
    const box = await canvas.boundingBox();
    await walk.still();
    await startClock(page);
    await gesture(page, box, viewer);
    await page.waitForTimeout(800); // the picture at rest, drawn in full, belongs to it
    const times = await stopClock(page, viewer);
    longest = Math.max(longest, times.frames.longest);
    console.log(name, JSON.stringify(times));
  }
  return longest;
}

if (process.argv[1] === new URL(import.meta.url).pathname) await main(process.argv.slice(2));
