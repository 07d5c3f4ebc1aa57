// The memory of a tab: its heap, as the browser counts it, and what the browser's processes keep.
import { readFileSync } from "node:fs";

const mb = (bytes) => Math.round(bytes / 1e5) / 10;

// The used heap of a page in MB, after collecting garbage.
export async function heap(page) {
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.enable");
  for (let i = 0; i < 2; ++i) await session.send("HeapProfiler.collectGarbage");
  await session.send("Performance.enable");
  const { metrics } = await session.send("Performance.getMetrics");
  await session.detach();
  const of = (name) => metrics.find((each) => each.name === name)?.value;
  return { used: mb(of("JSHeapUsedSize")), total: mb(of("JSHeapTotalSize")), nodes: of("Nodes"), listeners: of("JSEventListeners") };
}

// Resident MB of each kind of process, by what Linux says: the renderer has the page, its arrays and the drawing's lists; the
// GPU process has the buffers, which software rendering keeps in ordinary memory.
export async function processes(browser) {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  await session.detach();
  const sums = {};
  for (const { type, id } of processInfo) sums[type] = (sums[type] ?? 0) + residentMb(id);
  return Object.fromEntries(Object.entries(sums).map(([type, value]) => [type, Math.round(value)]));
}

function residentMb(id) {
  try {
    return Number(/^VmRSS:\s+(\d+) kB/m.exec(readFileSync(`/proc/${id}/status`, "utf8"))?.[1] ?? 0) / 1000;
  } catch {
    return 0; // it has ended meanwhile
  }
}
