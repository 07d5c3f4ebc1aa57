// Measures frame times and memory while a large pair is turned, zoomed, cut and brushed. Not a test of
// ctest: times belong to a machine that does nothing else.
//
//   node tests/web/browser/frames.mjs [WIDTH HEIGHT [A B]]     by default 960 600 and the corpus' pair of a million triangles,
//                                                              or one that is made where there is no corpus
//
// Prints the figures, and ends with 1 when a frame takes longer than 200 ms or the tab more memory than `most` says. With
// MESHGAUGE_PROFILE=FOLDER each gesture's profile is written to FOLDER/NAME.cpuprofile.
import { tmpdir } from "node:os";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { launch, Tab } from "./browser.mjs";
import { heap, processes } from "./memory.mjs";
import { corpus, dented, ply, sphere, written } from "./meshes.mjs";
import { Walk } from "./page.mjs";
import { startService } from "./service.mjs";
import { lookup } from "./workplace.mjs";

// Frames in ms. Memory in MB: the page's heap, and what the tab's and the drawing's processes keep more than before. For a pair
// that is decimated to 200,000 triangles a side, whatever its size was.
const most = { frame: 200, heap: 40, renderer: 350, GPU: 300 };
const leastDrawn = 5; // pictures while a gesture lasts: else it has not reached the canvas

export async function largePair(folder) {
  const [a, b] = ["armadillo_voxel1M.ply.gz", "armadillo_voxel1M_half.ply.gz"].map(corpus);
  if (a && b) return { a, b, name: "armadillo, 1,067,528 and 533,764 triangles" };
  const made = written(folder, { "sphere.ply": ply(sphere(500)), "dented.ply": ply(dented(370)) });
  return { a: made["sphere.ply"], b: made["dented.ply"], name: "a sphere and one with a dent, 1,000,000 and 547,600 triangles" };
}

// From the last frame to each next one, and how long each task kept the page.
function startClock(page, viewer) {
  return page.evaluate((host) => {
    const clock = (globalThis.clock = { frames: [], tasks: [], run: true, drawn: host?.viewer.frameTimes().length ?? 0 });
    let last = performance.now();
    const tick = (now) => {
      clock.frames.push(now - last);
      last = now;
      if (clock.run) requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
    clock.observer = new PerformanceObserver((list) => clock.tasks.push(...list.getEntries().map((each) => each.duration)));
    clock.observer.observe({ entryTypes: ["longtask"] });
  }, viewer);
}

async function stopClock(page, viewer) {
  const { frames, tasks } = await page.evaluate(() => {
    const { clock } = globalThis;
    clock.run = false;
    clock.observer.disconnect();
    return { frames: clock.frames, tasks: clock.tasks };
  });
  const drawn = await viewer.evaluate((host) => host.viewer.frameTimes().slice(globalThis.clock.drawn));
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
    await page.keyboard.press("0");
  },
  async cut(page) {
    await page.getByRole("button", { name: "Cut across x", exact: true }).click();
    const slider = page.getByRole("slider", { name: "Place of the cut" });
    for (let i = 0; i <= 24; ++i) {
      await slider.fill(String(Number((0.5 * Math.sin(i / 4)).toFixed(2))));
      await page.waitForTimeout(16);
    }
    await page.getByRole("button", { name: "Off: no cut", exact: true }).click();
  },
  async brush(page) {
    const track = await page.locator(".viewer-track").boundingBox();
    await drag(page, track, 30, (share) => [0.1 + 0.7 * share, 0.4]);
    await page.keyboard.press("Tab");
    await page.getByRole("button", { name: "All distances" }).click();
  },
  async edges(page) {
    await page.getByRole("button", { name: "Edges", exact: true }).click();
    await page.waitForTimeout(1500);
    await gestures.turn(page, await inView(page));
    await page.getByRole("button", { name: "Edges", exact: true }).click();
  },
  async "side by side"(page) {
    await page.getByRole("button", { name: "Side by side", exact: true }).click();
    const box = await inView(page);
    await gestures.turn(page, { ...box, width: box.width / 2 });
    await page.getByRole("button", { name: "Side by side", exact: true }).click();
  },
  async swap(page) {
    await page.getByRole("button", { name: "Swap", exact: true }).click();
    await gestures.turn(page, await inView(page));
  },
};

// The canvas' place, once it is visible: pressing a button of the toolbar may have scrolled the page.
async function inView(page) {
  const canvas = page.locator("canvas").first();
  await canvas.scrollIntoViewIfNeeded();
  await page.locator(".viewer-track").scrollIntoViewIfNeeded();
  return canvas.boundingBox();
}

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
  let service, browser;
  try {
    service = await startService();
    browser = await launch("--js-flags=--expose-gc", "--enable-precise-memory-info");
    const pair = files.length === 2 ? { a: files[0], b: files[1], name: files.join(" and ") } : await largePair(folder);
    const tab = await Tab.open(browser, service, { viewport: { width: Number(width), height: Number(height) }, reducedMotion: "no-preference" });
    console.log(`${pair.name}; window ${width} x ${height}, drawn by software`);
    const beyond = await measure(tab, pair);
    tab.assertClean({ expected: [lookup] });
    for (const line of beyond) console.log(`TOO MUCH: ${line}`);
    process.exitCode = beyond.length > 0 ? 1 : 0;
  } finally {
    await browser?.close();
    await service?.stop();
    rmSync(folder, { recursive: true, force: true });
  }
}

// The figures beyond their bounds, as lines.
async function measure(tab, pair) {
  const walk = await Walk.begin(tab), { page } = tab, browser = tab.context.browser();
  const before = await processes(browser), begun = performance.now();
  await walk.fill({ a: pair.a, b: pair.b });
  await walk.measure();
  await walk.measured();
  console.log(`result after ${Math.round(performance.now() - begun)} ms`);
  await startClock(page);
  const viewer = await walk.viewer();
  await settled(viewer);
  console.log(`picture after ${Math.round(performance.now() - begun)} ms`, JSON.stringify(await stopClock(page, viewer)));
  const beyond = await interact(walk, viewer);
  const kept = await processes(browser), { used } = await heap(page);
  const more = { heap: used, renderer: kept.renderer - before.renderer, GPU: kept.GPU - before.GPU };
  for (const [name, mb] of Object.entries(more)) {
    console.log(`${name}: ${Math.round(mb)} MB, at most ${most[name]} allowed`);
    if (!(mb <= most[name])) beyond.push(`${name} ${Math.round(mb)} MB`);
  }
  return beyond;
}

const settled = (viewer) => viewer.evaluate((host) => host.viewer.settled());

async function interact(walk, viewer) {
  const { page } = walk, beyond = [];
  for (const [name, gesture] of Object.entries(gestures)) {
    await page.locator("canvas").first().focus();
    const box = await inView(page);
    await settled(viewer);
    await startClock(page, viewer);
    const profile = await startProfile(page);
    await gesture(page, box, viewer);
    await settled(viewer); // the picture at rest, drawn in full, belongs to it
    await profile(name);
    const times = await stopClock(page, viewer);
    if (!(times.frames.longest <= most.frame)) beyond.push(`${name}: a frame of ${times.frames.longest} ms`);
    if (times.drawn.count < leastDrawn) beyond.push(`${name}: only ${times.drawn.count} pictures were drawn`);
    console.log(name, JSON.stringify(times));
  }
  return beyond;
}

async function startProfile(page) {
  if (!process.env.MESHGAUGE_PROFILE) return () => undefined;
  const session = await page.context().newCDPSession(page);
  await session.send("Profiler.enable");
  await session.send("Profiler.start");
  return async (name) => {
    const { profile } = await session.send("Profiler.stop");
    writeFileSync(join(process.env.MESHGAUGE_PROFILE, `${name}.cpuprofile`), JSON.stringify(profile));
    await session.detach();
  };
}

if (process.argv[1] === new URL(import.meta.url).pathname) await main(process.argv.slice(2));
