// The meshes of the README's pictures: a gear as it was drawn and as it came out of a printer, in millimetres, and a
// pair that takes long to measure.
import { rough, sheet } from "./browser/meshes.mjs";

const teeth = 18;
const [bore, root, tip, half] = [9, 26, 32, 5];

const smooth = (x) => Math.min(Math.max(x, 0), 1) ** 2 * (3 - 2 * Math.min(Math.max(x, 0), 1));

// A third of a tooth's pitch is its top, a third the gap, and the flanks lie between.
function outline(turn) {
  const within = (turn * teeth) % 1, flank = Math.abs(within - 0.5);
  return root + (tip - root) * smooth((0.36 - flank) / 0.16);
}

// Corners of a ring's section, walked around once: inside up, over the top, outside down, back below.
function section(v, outer) {
  const corners = [[bore, -half], [bore, half], [outer, half], [outer, -half]];
  const at = 4 * v, side = Math.min(Math.floor(at), 3), share = at - side;
  const [from, to] = [corners[side], corners[(side + 1) % 4]];
  return [0, 1].map((k) => from[k] + share * (to[k] - from[k]));
}

function gear(columns, rows, change) {
  return sheet(columns, rows, (u, v) => {
    const [radius, height] = section(v, outline(u)), turn = 2 * Math.PI * u;
    return change([radius * Math.cos(turn), radius * Math.sin(turn), height], u);
  }, { ring: true });
}

export const drawn = () => gear(teeth * 32, 64, (p) => p);

// Warped by a tenth of a millimetre as it cooled, with one tooth worn and a burr on top of another.
export function printed(place = (p) => p) {
  return gear(teeth * 24, 48, ([x, y, z], u) => {
    const away = Math.hypot(x, y) / tip, warp = 0.1 * away * away * Math.cos(4 * Math.PI * u);
    const worn = 1 - 0.028 * smooth(1 - Math.abs(u - 0.86) * teeth * 2) * smooth((away - 0.8) * 8);
    const burr = 0.55 * Math.exp(-((x + 20) ** 2 + (y - 15) ** 2) / 6);
    return place([x * worn, y * worn, z + warp + (z > 0 ? burr : 0)]);
  });
}

// The printed gear as a broken export left it: without a dozen triangles.
export function holed() {
  const { points, triangles } = printed();
  return { points, triangles: triangles.subarray(36) };
}

// The printed gear as a scanner saw it: turned by less than half a tooth, tilted by a few degrees, and shifted.
export function moved() {
  const [turn, tilt] = [0.14, 0.1];
  return printed(([x, y, z]) => {
    const [s, t] = [Math.cos(turn) * x - Math.sin(turn) * y, Math.sin(turn) * x + Math.cos(turn) * y];
    return [s + 4, Math.cos(tilt) * t - Math.sin(tilt) * z - 2, Math.sin(tilt) * t + Math.cos(tilt) * z + 1.5];
  });
}

// Two rough grounds of a million triangles: an interval that takes seconds and many steps.
export const ground = (which) => rough(700 + which, 0.2, which);
