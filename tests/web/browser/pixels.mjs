// Screenshots as numbers, and where a camera puts a point: written without the page's own modules, to be held against them.
import { PNG } from "pngjs";

// {width, height, at(x, y) -> [r, g, b]} of the bytes of a PNG.
export function picture(bytes) {
  const { width, height, data } = PNG.sync.read(bytes);
  const at = (x, y) => {
    const k = 4 * (Math.round(y) * width + Math.round(x));
    return [data[k], data[k + 1], data[k + 2]];
  };
  return { width, height, at };
}

export const difference = (one, other) => Math.max(...one.map((value, k) => Math.abs(value - other[k])));

// The pixels for which `chosen(colour, x, y)` is true: how many, their middle and the box around them.
export function spot(image, chosen) {
  const found = { count: 0, x: 0, y: 0, left: Infinity, top: Infinity, right: -1, bottom: -1 };
  for (let y = 0; y < image.height; ++y)
    for (let x = 0; x < image.width; ++x) {
      if (!chosen(image.at(x, y), x, y)) continue;
      found.count += 1;
      found.x += x + 0.5;
      found.y += y + 0.5;
      found.left = Math.min(found.left, x);
      found.right = Math.max(found.right, x + 1);
      found.top = Math.min(found.top, y);
      found.bottom = Math.max(found.bottom, y + 1);
    }
  found.x /= found.count;
  found.y /= found.count;
  return found;
}

// --- vectors -----------------------------------------------------------------------------------------------------

export const minus = (p, q) => p.map((x, k) => x - q[k]);
export const plus = (p, q, factor = 1) => p.map((x, k) => x + factor * q[k]);
export const dot = (p, q) => p.reduce((sum, x, k) => sum + x * q[k], 0);
export const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
export const length = (p) => Math.sqrt(dot(p, p));
export const unit = (p) => p.map((x) => x / length(p));

// --- colours -----------------------------------------------------------------------------------------------------

const helix = (share) => {
  const hue = ((300 + (115 - 300) * share) * Math.PI) / 180;
  return [0.25 + 0.68 * share, 0.02 + 0.12 * Math.cos(hue), 0.01 + 0.12 * Math.sin(hue)];
};

function oklabToLinear([lightness, a, b]) {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s, -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s];
}

function encoded(linear) {
  const c = Math.min(Math.max(linear, 0), 1);
  return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
}

// The colour of a distance by api/map/colour_map.h: the map up to the limit, or up to the largest distance where there is none, and
// one dark red beyond a limit.
export function colourOf(distance, top, limited) {
  if (limited && distance > top) return [190, 12, 0];
  const share = top > 0 ? Math.min(distance / top, 1) : 0;
  return oklabToLinear(helix(Math.round(share * 1024) / 1024)).map(encoded);
}

// --- the camera --------------------------------------------------------------------------------------------------

// Where a camera, as the viewer reports it (viewer/camera.ts), shows a point, in CSS pixels of the window: by the matrices of
// textbooks, a view matrix and a projection, in double precision.
export function projected({ position, target, up, fov, viewport }, point) {
  const back = unit(minus(position, target)), right = unit(cross(up, back)), above = cross(back, right);
  const seen = minus(point, position), [x, y, z] = [dot(right, seen), dot(above, seen), dot(back, seen)];
  const f = 1 / Math.tan((fov * Math.PI) / 360), aspect = viewport.width / viewport.height;
  const [ndcX, ndcY] = [((f / aspect) * x) / -z, (f * y) / -z];
  return { x: viewport.left + ((ndcX + 1) / 2) * viewport.width, y: viewport.top + ((1 - ndcY) / 2) * viewport.height, depth: -z };
}
