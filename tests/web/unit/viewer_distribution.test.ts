// Areas by distance, the axis of the colour bar, and the brush on it.
import assert from "node:assert/strict";
import test from "node:test";
import { AreaDistribution, shareBelow, type Surface } from "../../../server/web/page/viewer/distribution";
import { axisOf, binEdges, brushBetween, distanceAt, isWhole, moveEnd, placeOf, wholeBrush } from "../../../server/web/page/viewer/scale";
import { atLeast, figure, percent } from "../../../server/web/page/viewer/words";

const near = (a: number, b: number, within = 1e-6): void => assert.ok(Math.abs(a - b) <= within, `${a} and ${b}`);

// Two triangles of area 1/2 and 2.
const surface = (distances: number[]): Surface => ({
  positions: new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 1, 0, 2, 1]),
  indices: new Uint32Array([0, 1, 2, 3, 4, 5]),
  distances: new Float32Array(distances),
});

test("the share of a triangle that is nearer is that of many samples", () => {
  for (const [low, middle, high] of [[0, 0.3, 1], [0.2, 0.2, 1], [0, 1, 1], [0.5, 0.6, 0.7]] as const) {
    const n = 400;
    for (const t of [0.1, 0.25, 0.55, 0.65, 0.9]) {
      let below = 0;
      let all = 0;
      for (let i = 0; i < n; ++i) {
        for (let j = 0; i + j < n; ++j, ++all) {
          const [u, v] = [(i + 1 / 3) / n, (j + 1 / 3) / n];
          if (low * (1 - u - v) + middle * u + high * v < t) ++below;
        }
      }
      near(shareBelow(t, low, middle, high), below / all, 0.01);
    }
  }
});

test("areas weigh, not triangles or vertices", () => {
  const areas = new AreaDistribution(surface([0.1, 0.1, 0.1, 0.9, 0.9, 0.9]));
  near(areas.total, 2.5);
  near(areas.largest, 0.9);
  near(areas.share(0, 0.5), 0.2);
  near(areas.share(0.5, 1), 0.8);
  near(areas.share(0, 1), 1);
  near(areas.share(0.9, 0.9), 0.8);
  assert.equal(areas.share(0.6, 0.5), 0);
});

test("bins are the shares between their edges and add up to all", () => {
  const areas = new AreaDistribution(surface([0, 0.2, 1, 0.4, 0.5, 0.6]));
  const edges = binEdges(axisOf(0.5, areas.largest), 20);
  const bins = areas.bins(edges);
  near(bins.reduce((sum, share) => sum + share, 0), 1);
  bins.forEach((share, i) => near(share, areas.share(edges[i]!, edges[i + 1]!)));
});

test("a surface at distance 0 is all in the first bin, one without area in none", () => {
  const bins = new AreaDistribution(surface([0, 0, 0, 0, 0, 0])).bins(binEdges(axisOf(1, 0), 10));
  near(bins[0]!, 1);
  const flat = { ...surface([0, 1, 2, 0, 1, 2]), positions: new Float32Array(18) };
  assert.deepEqual([...new AreaDistribution(flat).bins([0, 1, 2])], [0, 0]);
  assert.equal(new AreaDistribution(flat).share(0, 9), 0);
});

test("places and distances of the axis are inverse, above the limit too", () => {
  for (const axis of [axisOf(1, 0.5), axisOf(1, 40), axisOf(0, 3), axisOf(2, 2)]) {
    for (const place of [0, 0.1, 0.5, 0.79, 0.8, 0.81, 0.99, 1]) {
      if (axis.split === 0 && place === 0) continue;
      near(placeOf(axis, distanceAt(axis, place)), place);
    }
  }
  assert.equal(placeOf(axisOf(0, 0), 0), 0);
  assert.ok(binEdges(axisOf(0.3, 7), 120).includes(0.3), "an edge is at the limit");
});

test("ends of the brush neither cross nor leave the axis", () => {
  const brush = { from: 3, to: 6 };
  assert.deepEqual(moveEnd(brush, "from", 9, 10), { from: 5, to: 6 });
  assert.deepEqual(moveEnd(brush, "from", -4, 10), { from: 0, to: 6 });
  assert.deepEqual(moveEnd(brush, "to", 0, 10), { from: 3, to: 4 });
  assert.deepEqual(moveEnd(brush, "to", 99, 10), { from: 3, to: 10 });
});

test("a brush that is drawn holds the places it was drawn over, at least a bin", () => {
  assert.deepEqual(brushBetween(0.62, 0.31, 10), { from: 3, to: 7 });
  assert.deepEqual(brushBetween(0.5, 0.5, 10), { from: 5, to: 6 });
  assert.deepEqual(brushBetween(1.4, 1.2, 10), { from: 9, to: 10 });
  assert.ok(isWhole(brushBetween(-1, 2, 10), 10));
  assert.ok(isWhole(wholeBrush(10), 10));
});

test("figures: at least is never above, shares are never rounded to nothing or all", () => {
  for (const value of [0.07319, 0.0999999, 123456.7, 9.9999e-12, 1, 0.3]) {
    assert.ok(Number(atLeast(value)) <= value, atLeast(value));
    near(Number(atLeast(value)) / value, 1, 2e-3);
  }
  assert.equal(atLeast(0.07319, 3), "0.0731");
  assert.equal(atLeast(0), "0");
  assert.equal(figure(0.30000000000000004), "0.3");
  assert.deepEqual([0, 1e-7, 0.0312, 0.99999, 1].map(percent), ["0 %", "less than 0.01 %", "3.12 %", "more than 99.99 %", "100 %"]);
});
