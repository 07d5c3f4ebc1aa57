// The witness's marks in a screenshot, found without knowing where they should be.

const magenta = ([red, green, blue]) => red > 190 && green < 110 && blue > 190;

// The two thickest magenta spots: {disc: {x, y}, square: {x, y}} in pixels of the image, whose corner is (0, 0); the pixel in
// that corner has its middle at (0.5, 0.5). A spot's place is the centre of the largest circle within it, so that the segment
// which joins the two does not move it. Fails unless there are exactly one disc and one square on its tip.
export function findMarks(image) {
  const inside = (x, y) => x >= 0 && y >= 0 && x < image.width && y < image.height && magenta(image.at(x, y));
  const first = thickest(image, inside, () => true);
  const second = thickest(image, inside, (x, y) => Math.hypot(x - first.x, y - first.y) > 12);
  const kinds = [first, second].map((spot) => ({ ...spot, kind: kindOf(inside, spot) }));
  const disc = kinds.find((each) => each.kind === "disc"), square = kinds.find((each) => each.kind === "square");
  if (!disc || !square || second.radius < 4) throw new Error(`not a disc and a square, but ${JSON.stringify(kinds)}`);
  return { disc, square };
}

// The disc of a point on one side, which has no nearest point: {x, y, radius}.
export function findDisc(image) {
  const inside = (x, y) => x >= 0 && y >= 0 && x < image.width && y < image.height && magenta(image.at(x, y));
  const spot = thickest(image, inside, () => true);
  if (kindOf(inside, spot) !== "disc") throw new Error(`not a disc: ${JSON.stringify(spot)}`);
  return spot;
}

function thickest(image, inside, allowed) {
  let best = { radius: 0, x: NaN, y: NaN };
  for (let y = 0; y < image.height; ++y)
    for (let x = 0; x < image.width; ++x) {
      if (!inside(x, y) || !allowed(x, y)) continue;
      const radius = room(inside, x + 0.5, y + 0.5);
      if (radius > best.radius) best = { radius, x: x + 0.5, y: y + 0.5 };
    }
  return Number.isNaN(best.x) ? best : refined(inside, best);
}

// The middle of the places with about the most room, among places an eighth of a pixel apart.
function refined(inside, { x: nearX, y: nearY }) {
  const tried = [];
  for (let x = nearX - 1.5; x <= nearX + 1.5; x += 0.125)
    for (let y = nearY - 1.5; y <= nearY + 1.5; y += 0.125) tried.push({ x, y, radius: room(inside, x, y) });
  const most = Math.max(...tried.map((each) => each.radius));
  const good = tried.filter((each) => each.radius > most - 0.05);
  const mean = (key) => good.reduce((sum, each) => sum + each[key], 0) / good.length;
  return { x: mean("x"), y: mean("y"), radius: most };
}

// The distance to the middle of the nearest pixel outside.
function room(inside, x, y) {
  let nearest = 12;
  const [column, row] = [Math.floor(x), Math.floor(y)];
  for (let j = row - 9; j <= row + 9; ++j)
    for (let i = column - 9; i <= column + 9; ++i)
      if (!inside(i, j)) nearest = Math.min(nearest, Math.hypot(i + 0.5 - x, j + 0.5 - y));
  return nearest;
}

// A square on its tip has no corners at 45 degrees; a disc of the same size has no tips.
function kindOf(inside, { x, y }) {
  const filled = [[4, 4], [4, -4], [-4, 4], [-4, -4]].filter(([i, j]) => inside(Math.floor(x + i), Math.floor(y + j))).length;
  return filled >= 3 ? "disc" : filled <= 1 ? "square" : "neither";
}
