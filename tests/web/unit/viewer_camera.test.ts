// What is seen where: projections against three.js, flights, views of the witness, rays, and meshes made for display.
import assert from "node:assert/strict";
import test from "node:test";
import { PerspectiveCamera, Vector3 } from "three";
import { distanceFor, flight, nearFar, project, rayThrough, wholeView, witnessView, type CameraState } from "../../../server/web/page/viewer/camera";
import { beforeCamera, hiddenBy } from "../../../server/web/page/viewer/marks";
import { Pace } from "../../../server/web/page/viewer/pace";
import { Rays } from "../../../server/web/page/viewer/rays";
import { boundsOf, coarsened, edgesInSteps, edgesOf, reachOf, signedVolume, unionOf, type Mesh } from "../../../server/web/page/viewer/shape";
import { add, dot, length, scale, sub, unit, type Vec3 } from "../../../server/web/page/viewer/vec";

const near = (a: number, b: number, within = 1e-6): void => assert.ok(Math.abs(a - b) <= within, `${a} and ${b}`);
const viewport = { left: 30, top: 70, width: 800, height: 500 };
const camera: CameraState = {
  position: [3, -4, 2.5], target: [0.2, 0.1, 0], up: [0, 0, 1], fov: 35, near: 0.1, far: 20, origin: [0, 0, 0], viewport, viewports: [viewport],
};

function sphere(rings: number, middle: Vec3 = [0, 0, 0]): Mesh {
  const positions: number[] = [];
  const indices: number[] = [];
  for (let i = 0; i <= rings; ++i) {
    for (let j = 0; j < 2 * rings; ++j) {
      const [a, b] = [(Math.PI * i) / rings, (Math.PI * j) / rings];
      positions.push(middle[0] + Math.sin(a) * Math.cos(b), middle[1] + Math.sin(a) * Math.sin(b), middle[2] + Math.cos(a));
      const [p, q] = [i * 2 * rings + j, i * 2 * rings + ((j + 1) % (2 * rings))];
      if (i < rings) indices.push(p, p + 2 * rings, q, q, p + 2 * rings, q + 2 * rings);
    }
  }
  return { positions: new Float32Array(positions), indices: new Uint32Array(indices) };
}

test("a point is projected to where three.js draws it", () => {
  const lens = new PerspectiveCamera(camera.fov, viewport.width / viewport.height, camera.near, camera.far);
  lens.up.set(...camera.up);
  lens.position.set(...camera.position);
  lens.lookAt(new Vector3(...camera.target));
  lens.updateMatrixWorld();
  lens.updateProjectionMatrix();
  for (const p of [[0, 0, 0], [1, 0.4, -0.7], [-0.8, 1, 0.9]] as Vec3[]) {
    const ndc = new Vector3(...p).project(lens);
    const { x, y, depth } = project(camera, p);
    near(x, viewport.left + ((ndc.x + 1) / 2) * viewport.width, 1e-3);
    near(y, viewport.top + ((1 - ndc.y) / 2) * viewport.height, 1e-3);
    assert.ok(depth > 0);
  }
  assert.ok(project(camera, add(camera.position, [3, -4, 2.5])).depth < 0, "behind the camera");
});

test("far from the origin a projection keeps its digits", () => {
  const far: Vec3 = [1e6, -2e6, 3e6];
  const moved = { ...camera, position: add(camera.position, far), target: add(camera.target, far) };
  const [here, there] = [project(camera, [0.3, 0.4, 0.5]), project(moved, add([0.3, 0.4, 0.5], far))];
  near(here.x, there.x, 1e-5);
  near(here.y, there.y, 1e-5);
});

test("a ray through a pixel meets the point that is projected there", () => {
  const p: Vec3 = [0.5, -0.2, 0.3];
  const { x, y } = project(camera, p);
  near(dot(unit(rayThrough(camera, x, y, viewport)), unit(sub(p, camera.position))), 1, 1e-12);
});

test("the whole view holds the ball, the planes leave nothing of it out", () => {
  const centre: Vec3 = [10, 20, 30];
  for (const up of [[0, 0, 1], [0, 1, 0]] as Vec3[]) {
    const seen = { ...camera, ...wholeView(centre, 2, up, 35, 1) };
    const planes = nearFar(seen.position, seen.target, centre, 2);
    for (const d of [[1, 0, 0], [0, -1, 0], [0, 0, 1], unit([1, 1, 1])] as Vec3[]) {
      const { x, y, depth } = project(seen, add(centre, scale(d, 2)));
      assert.ok(x >= 30 && x <= 830 && y >= 70 && y <= 570, `${x} ${y}`);
      assert.ok(depth > planes.near && depth < planes.far);
    }
  }
  const inside = nearFar([0.1, 0, 0], [0, 0, 0], [0, 0, 0], 1);
  assert.ok(inside.near > 0 && inside.near < 0.01);
});

test("the whole view is from where the point is seen, and from the front if it is seen from there or from nowhere", () => {
  const whole = (sees: (from: Vec3) => boolean) => wholeView([0, 0, 0], 2, [0, 0, 1], 35, 1, sees).position;
  const usual = whole(() => true);
  assert.ok(usual[0] > 0 && usual[1] < 0 && usual[2] > 0);
  assert.deepEqual(whole(() => false), usual);
  assert.ok(whole(([, y]) => y > 0)[1] > 0, "from behind");
  assert.ok(whole(([, , z]) => z < 0)[2] < 0, "from below");
});

test("the view of a witness has both points well inside and apart, from where nothing covers them", () => {
  const pair = { point: [0, 0, 1] as Vec3, nearest: [0, 0, 1.05] as Vec3 };
  const ball = new Rays(sphere(24));
  const isFree = (eye: Vec3, p: Vec3): boolean => !hiddenBy((o, d, to) => ball.first(o, d, 0, to) !== undefined, eye, p, 0.01);
  const below = { ...camera, position: [0, 0.1, -6] as Vec3, target: [0, 0, 0] as Vec3 };
  const view = { ...below, ...witnessView(pair, below, { aspect: 1.6, context: 0.01, isFree }) };
  const [p, q] = [project(view, pair.point), project(view, pair.nearest)];
  for (const { x, y } of [p, q]) assert.ok(x > 130 && x < 730 && y > 120 && y < 520, `${x} ${y}`);
  assert.ok(Math.hypot(p.x - q.x, p.y - q.y) > 60);
  assert.ok(isFree(view.position, pair.point));
});

test("a flight begins and ends where it should, and its way is smooth", () => {
  const from = { position: [0, 0, 10] as Vec3, target: [0, 0, 0] as Vec3 };
  for (const to of [{ position: [1, 1, 1.2] as Vec3, target: [1, 1, 1] as Vec3 }, { position: [0, 0, -10] as Vec3, target: [0, 0, 0] as Vec3 }]) {
    near(length(sub(flight(from, to, 0).position, from.position)), 0);
    assert.deepEqual(flight(from, to, 1), to);
    for (let i = 0; i < 100; ++i) {
      const [a, b] = [flight(from, to, i / 100), flight(from, to, (i + 1) / 100)];
      assert.ok(length(sub(a.position, b.position)) < 1.2, `step ${i}`);
      assert.ok(length(sub(a.position, a.target)) > 0.1);
    }
  }
});

test("a segment is cut at the near plane", () => {
  const behind = add(camera.position, sub(camera.position, camera.target));
  const cut = beforeCamera(camera, [0, 0, 0], behind);
  assert.ok(cut);
  near(project(camera, cut[1]).depth, camera.near, 1e-9);
  assert.equal(beforeCamera(camera, behind, behind), undefined);
});

test("rays meet the nearest triangle, and only what a cut leaves", () => {
  const rays = new Rays(sphere(16));
  near(rays.first([0.01, 0.02, 5], [0, 0, -1])!.t, 4, 0.02);
  near(rays.first([0.01, 0.02, 5], [0, 0, -2])!.t, 2, 0.02);
  near(rays.first([0.01, 0.02, 5], [0, 0, -1], 0, Infinity, ([, , z]) => z < 0)!.t, 6, 0.02);
  assert.equal(rays.first([2, 0, 5], [0, 0, -1]), undefined);
  assert.equal(rays.first([0.01, 0.02, 5], [0, 0, -1], 0, 3.5), undefined);
  near(rays.first([0.3, 0.2, 5], [0, 0, -1])!.weights.reduce((a, b) => a + b), 1);
});

test("what is just before the eye's end does not hide it", () => {
  const rays = new Rays(sphere(16));
  const hides = (p: Vec3): boolean => hiddenBy((o, d, to) => rays.first(o, d, 0, to) !== undefined, [0.01, 0.02, 5], p, 0.05);
  assert.equal(hides([0, 0, 0.97]), false);
  assert.equal(hides([0, 0, -1]), true);
});

test("boxes and reach are of the triangles, not of stray vertices", () => {
  const mesh = sphere(12, [5, 0, 0]);
  const stray = { positions: new Float32Array([...mesh.positions, 900, 900, 900]), indices: mesh.indices };
  const box = boundsOf(stray, [100, 0, 0]);
  near(box!.high[0], 106, 0.02);
  near(reachOf(stray, [100, 0, 0], [105, 0, 0]), 1, 1e-5);
  assert.deepEqual(unionOf([undefined, undefined]), { low: [-1, -1, -1], high: [1, 1, 1] });
  assert.equal(boundsOf({ positions: stray.positions, indices: new Uint32Array(0) }, [0, 0, 0]), undefined);
});

test("a volume's sign tells which side is out", () => {
  const mesh = sphere(16, [40, 0, 0]);
  near(signedVolume(mesh) / 6, (4 / 3) * Math.PI, 0.1);
  assert.ok(signedVolume({ ...mesh, indices: mesh.indices.slice().reverse() }) < 0);
});

test("edges come once each", () => {
  const tetrahedron = { positions: new Float32Array(12), indices: new Uint32Array([0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0]) };
  const edges = edgesOf(tetrahedron);
  const pairs = new Set(Array.from({ length: edges.length / 2 }, (_, i) => `${edges[2 * i]} ${edges[2 * i + 1]}`));
  const large = sphere(120);
  const steps = [...edgesInSteps(large)];
  assert.ok(steps.length > 5, "made in steps");
  assert.equal(edgesOf(large).length / 2, new Set(Array.from(large.indices, (p, i) => [p, large.indices[i % 3 === 2 ? i - 2 : i + 1]!].sort((x, y) => x - y).join(" "))).size);
  assert.equal(edges.length, 12);
  assert.equal(pairs.size, 6);
});

test("a coarse mesh has about as many triangles as asked, none of no area, and only vertices of the mesh", () => {
  const mesh = sphere(120);
  const indices = coarsened(mesh, 5000);
  assert.ok(indices.length / 3 <= 5000 && indices.length / 3 > 1500, String(indices.length / 3));
  for (let i = 0; i < indices.length; i += 3) assert.equal(new Set(indices.slice(i, i + 3)).size, 3);
  near(reachOf({ ...mesh, indices }, [0, 0, 0], [0, 0, 0]), 1, 1e-3);
  assert.equal(coarsened(mesh, 1e6), mesh.indices);
});

test("slow frames make the picture coarser at once, quick ones finer in time", () => {
  const pace = new Pace(false, 1e6);
  assert.deepEqual(pace.moving, { scale: 1, coarse: 0 });
  pace.took(120);
  pace.took(300);
  assert.ok(pace.moving.scale < 1 && pace.moving.coarse > 0);
  const slow = pace.moving;
  pace.took(10);
  assert.deepEqual(pace.moving, slow);
  for (let i = 0; i < 200; ++i) pace.took(10);
  assert.deepEqual(pace.moving, { scale: 1, coarse: 0 });
  for (let i = 0; i < 50; ++i) pace.took(999);
  assert.ok(pace.moving.scale >= 0.3);
  const software = new Pace(true, 1e6);
  for (let i = 0; i < 500; ++i) {
    assert.ok(software.moving.coarse > 0, "never all triangles at once");
    software.took(5);
  }
  near(distanceFor(1, 90, 1), Math.SQRT2);
});
