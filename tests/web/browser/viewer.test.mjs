// The viewer against the service: the witness is drawn where the API says, colours are those of the numbers in the PLY.
import assert from "node:assert/strict";
import { parsePly } from "./files.mjs";
import { findDisc, findMarks } from "./marks.mjs";
import { dented, obj, scaled, sphere, stl } from "./meshes.mjs";
import { colourOf, cross, difference, dot, length, minus, picture, plus, projected, unit } from "./pixels.mjs";
import { asked } from "./service.mjs";
import { lookup, todays, workplace } from "./workplace.mjs";

// Far from the origin, as parts of a plant are: single precision of the whole coordinate would be seen.
const far = [120_000, -45_000, 8_000];

// A sphere with a dent and a bump.
const dent = [1 / 3, 2 / 3, 2 / 3], bump = [2 / 3, -1 / 3, 2 / 3];
const bulge = (d, way) => 0.1 * Math.exp(-20 * (1 - dot(d, way)));

const test = todays(2);
const place = workplace(() => ({
  "both.obj": obj(scaled(sphere(24, (d) => 1 - bulge(d, dent) + bulge(d, bump)), 20)),
  "dented.obj": obj(scaled(dented(24), 20)), "sphere.stl": stl(scaled(sphere(40), 20)),
  "far_dented.obj": obj(scaled(dented(24), 20, far)), "far_sphere.obj": obj(scaled(sphere(40), 20, far)),
}));

async function measured(a, b, more = {}) {
  const walk = await place.open(), { tab } = walk;
  await walk.fill({ a: place.files[a], b: place.files[b], ...more });
  await walk.measure();
  await walk.measured();
  const viewer = await walk.viewer();
  // The viewer begins with the side that the witness lies on.
  if (await tab.page.getByText("Area of B by its distance to A").count()) await walk.press("Swap");
  await walk.still();
  return { tab, walk, viewer, result: (await walk.job()).result };
}

const cameraOf = (viewer) => viewer.evaluate((host) => host.viewer.camera());

async function lookFrom(walk, viewer, camera) {
  await viewer.evaluate((host, to) => host.viewer.setCamera({ ...host.viewer.camera(), ...to }), camera);
  await walk.still();
}

// A screenshot of the canvas, and the camera as the viewer reports it.
async function look({ tab, viewer, walk }, name) {
  await tab.page.locator("canvas").evaluate((canvas) => canvas.scrollIntoView({ block: "center", behavior: "instant" }));
  await walk.still();
  const image = picture(await tab.shot(name)), camera = await cameraOf(viewer);
  return { image, camera };
}

// The pair of points of the interval's lower end, from the API alone.
function witnessOf({ a_to_b, b_to_a }) {
  const sides = [a_to_b, b_to_a].filter((side) => side?.witness);
  const { point_a, point_b } = sides.sort((one, other) => other.lower - one.lower)[0].witness;
  return { point: point_a, nearest: point_b };
}

// Turns around the target by degrees, and moves nearer by a factor.
function around({ position, target, up }, degrees, factor) {
  const offset = minus(position, target), k = unit(up), turn = (degrees * Math.PI) / 180;
  const turned = plus(plus(offset.map((x) => x * Math.cos(turn)), cross(k, offset), Math.sin(turn)), k, dot(k, offset) * (1 - Math.cos(turn)));
  return { position: plus(target, turned.map((x) => x * factor)) };
}

for (const [a, b, where] of [["dented.obj", "sphere.stl", "near the origin"], ["far_dented.obj", "far_sphere.obj", "far from the origin"]]) {
  test(`the witness is drawn within a pixel of where the API says, from three places: ${where}`, async () => {
    const walked = await measured(a, b), { walk, viewer, tab, result } = walked;
    const pair = witnessOf(result);
    const { position, target } = await cameraOf(viewer); // it may begin from behind
    await lookFrom(walk, viewer, { position: plus(target, unit([0.6, -1, 0.5]), length(minus(position, target))) });
    await viewer.evaluate((host) => host.viewer.flyToWitness(0));
    await walk.still();
    const flown = await cameraOf(viewer);
    for (const [i, [degrees, factor]] of [[0, 1], [24, 1.6], [-12, 0.7]].entries()) {
      await lookFrom(walk, viewer, around(flown, degrees, factor));
      const { image, camera } = await look(walked, `witness_${where.split(" ")[0]}_${i + 1}`);
      const marks = findMarks(image);
      for (const [mark, point] of [["disc", pair.point], ["square", pair.nearest]]) {
        const expected = projected(camera, point), off = Math.hypot(marks[mark].x - expected.x, marks[mark].y - expected.y);
        console.log(`${where}, camera ${i + 1}, ${mark}: ${off.toFixed(2)} px off`);
        assert.ok(off <= 1, `${mark} at ${marks[mark].x}, ${marks[mark].y}, expected at ${expected.x}, ${expected.y}`);
      }
    }
    tab.assertClean({ expected: [lookup] });
    await tab.close();
  });
}

test("plain colours are those of the PLY's distances, at every vertex that is seen", async () => {
  for (const limit of ["1.2", ""]) {
    const walked = await measured("dented.obj", "sphere.stl", { limit }), { walk, tab, result } = walked;
    await plainColours(walk);
    await faceTheDent(walked);
    const [ply, other] = [await plyOf(walk, "a"), await plyOf(walk, "b")];
    const top = limit === "" ? Math.max(...ply.distances, ...other.distances) : Number(limit);
    const scale = { top, limited: limit !== "" };
    const reached = await compareColours(walked, ply, scale, witnessOf(result), limit === "" ? "colours_without_limit" : "colours");
    assert.ok(reached.seen >= 100, `${reached.seen} vertices are seen`);
    assert.ok(limit === "" || reached.above > 3, "the colour above the limit is among them");
    tab.assertClean({ expected: [lookup] });
    await tab.close();
  }
});

test("where sides are asked for, what lies inside is blue, what lies outside orange, and the scale says so", async () => {
  const walked = await measured("both.obj", "sphere.stl", { inside: "1", outside: "3" }), { walk, viewer, tab } = walked;
  await tab.page.getByText(/distance to B,\s+outside of B,\s+above 3,\s+inside of B,\s+above 1 /).waitFor();
  await tab.page.getByText(/ % of A’s area is more than 1 inside of B/).waitFor();
  assert.equal(await tab.page.locator(".viewer-bar").getAttribute("viewBox"), "0 0 240 2");
  await plainColours(walk);
  const { position, target } = await cameraOf(viewer);
  await lookFrom(walk, viewer, { position: plus(target, unit(plus(dent, bump)), length(minus(position, target))) });
  const { image, camera } = await look(walked, "sides"), ply = await plyOf(walk, "a"), normals = normalsOf(ply);
  const disc = findDisc(image), labels = await labelBoxes(tab.page), seen = { inside: 0, outside: 0 };
  ply.points.forEach((point, i) => {
    const signed = ply.signed[i], { x, y } = projected(camera, point);
    if (!(Math.abs(signed) > 0.7) || dot(normals[i], unit(minus(camera.position, point))) < 0.5) return;
    if (Math.hypot(x - disc.x, y - disc.y) < 14 || labels.some((box) => within(box, x, y))) return;
    const beyond = signed < -1;  // in dark violet
    const [red, green, blue] = image.at(Math.floor(x), Math.floor(y)), side = signed < 0 ? "inside" : "outside";
    assert.ok((signed < 0 ? blue - red : red - blue) > 30, `${side} by ${signed}: ${red}, ${blue}`);
    assert.equal(beyond, signed < 0 && Math.max(red, green) < 70, `${signed}: ${red}, ${green}`);
    seen[side] += 1;
  });
  console.log(`${seen.inside} vertices inside, ${seen.outside} outside`);
  assert.ok(seen.inside > 3 && seen.outside > 3);
  await walk.press("Swap");
  await walk.still();
  assert.equal(await tab.page.locator(".viewer-bar").getAttribute("viewBox"), "0 0 240 1");
  tab.assertClean({ expected: [lookup] });
  await tab.close();
});

async function plyOf(walk, side) {
  return parsePly(await (await asked(place.service, `/v1/comparisons/${walk.id()}/deviation.ply?of=${side}`)).arrayBuffer());
}

async function faceTheDent({ walk, viewer }) {
  const { position, target } = await cameraOf(viewer);
  await lookFrom(walk, viewer, { position: plus(target, [1 / 3, 2 / 3, 2 / 3], length(minus(position, target))) });
}

async function compareColours(walked, ply, scale, { point, nearest }, name) {
  const { image, camera } = await look(walked, name), labels = await labelBoxes(walked.tab.page);
  const normals = normalsOf(ply), seen = [], marks = [point, nearest].map((each) => projected(camera, each));
  // Whether a mark or a label covers the pixel.
  const covered = (x, y) => marks.some((mark) => Math.hypot(x - mark.x, y - mark.y) < 14) || labels.some((box) => within(box, x, y));
  ply.points.forEach((point, i) => {
    const toEye = unit(minus(camera.position, point));
    if (dot(normals[i], toEye) < 0.5) return;
    const { x, y } = projected(camera, point);
    if (covered(x, y)) return;
    seen.push({ i, expected: colourOf(ply.distances[i], scale.top, scale.limited), shown: image.at(Math.floor(x), Math.floor(y)) });
  });
  const own = scale.limited ? scale.top : Math.max(...ply.distances); // without a limit each file's colours end at its own largest
  for (const { i } of seen) assert.deepEqual(ply.colours[i], colourOf(ply.distances[i], own, scale.limited), "the PLY's own colour");
  const off = seen.map((each) => difference(each.expected, each.shown)).sort((x, y) => x - y);
  console.log(`${name}: ${seen.length} vertices, off by ${off[Math.floor(off.length / 2)]} of 255 in the middle, by ${off.at(-1)} at most`);
  const far = seen.filter((each) => difference(each.expected, each.shown) > tolerance(ply, each.i, scale, camera));
  assert.deepEqual(far, [], "colours that are not those of the distance");
  return { seen: seen.length, above: seen.filter((each) => scale.limited && ply.distances[each.i] > scale.top).length };
}

const labelBoxes = (page) => page.locator(".viewer-label").evaluateAll((all) => all.map((each) => each.getBoundingClientRect().toJSON()));
const within = ({ left, right, top, bottom }, x, y) => x > left - 2 && x < right + 2 && y > top - 2 && y < bottom + 2;

// A pixel's middle lies up to 0.7 pixels from the vertex, and what is smoothed up to 1.5: as much as the distance changes over
// there, the colour may differ. Beside the limit it may be either side's.
function tolerance(ply, vertex, { top, limited }, camera) {
  const steepest = Math.max(...neighboursOf(ply)[vertex].map((other) =>
    Math.abs(ply.distances[other] - ply.distances[vertex]) / length(minus(ply.points[other], ply.points[vertex]))));
  const pixel = length(minus(camera.position, ply.points[vertex])) * 2 * Math.tan((camera.fov * Math.PI) / 360) / camera.viewport.height;
  const change = 3 * steepest * pixel, distance = ply.distances[vertex];
  if (limited && Math.abs(distance - top) < change) return 255;
  const near = [distance - change, distance + change].map((d) => colourOf(Math.max(d, 0), top, limited));
  return 3 + Math.max(...near.map((colour) => difference(colour, colourOf(distance, top, limited))));
}

const neighbours = new WeakMap();
function neighboursOf(ply) {
  if (!neighbours.has(ply)) {
    const lists = ply.points.map(() => []);
    for (const corners of ply.triangles) for (const p of corners) for (const q of corners) if (p !== q) lists[p].push(q);
    neighbours.set(ply, lists);
  }
  return neighbours.get(ply);
}

function normalsOf(ply) {
  const normals = ply.points.map(() => [0, 0, 0]);
  for (const [p, q, r] of ply.triangles) {
    const normal = cross(minus(ply.points[q], ply.points[p]), minus(ply.points[r], ply.points[p]));
    for (const corner of [p, q, r]) normals[corner] = plus(normals[corner], normal);
  }
  return normals.map((normal) => (length(normal) > 0 ? unit(normal) : normal));
}

// Shows the mesh without the other one over it, and without light.
async function plainColours(walk) {
  await walk.click("Plain colours");
  await walk.click("Show mesh B");
  await walk.still();
}
