// Arithmetic of the camera, in double precision and without three.js.
import { add, aside, cross, dot, length, mix, scale, sub, unit, type Vec3 } from "./vec";

export interface Rect {
  left: number; // CSS pixels within the window
  top: number;
  width: number;
  height: number;
}

// Everything that a projection needs. Points are in the meshes' own coordinates: the renderer moves them by `origin`, which is
// not subtracted here.
export interface CameraState {
  position: Vec3;
  target: Vec3;
  up: Vec3;
  fov: number; // degrees, vertical
  near: number;
  far: number;
  origin: Vec3;
  viewport: Rect; // of the only picture, or of the left one
  viewports: Rect[]; // both, side by side
}

export interface Axes {
  right: Vec3;
  up: Vec3;
  back: Vec3; // towards the viewer
}

export function axesOf(camera: Pick<CameraState, "position" | "target" | "up">): Axes {
  const back = unit(sub(camera.position, camera.target));
  let right = unit(cross(camera.up, back));
  if (length(right) === 0) right = aside(back);
  return { right, up: cross(back, right), back };
}

export interface Projected {
  x: number; // CSS pixels, within the window
  y: number;
  depth: number; // in front of the camera, in the meshes' unit; not above 0 behind it
}

export function project(camera: CameraState, point: Vec3, viewport: Rect = camera.viewport): Projected {
  const { right, up, back } = axesOf(camera);
  const seen = sub(point, camera.position);
  const depth = -dot(seen, back);
  const perUnit = viewport.height / (2 * Math.tan((camera.fov * Math.PI) / 360)) / depth;
  return {
    x: viewport.left + viewport.width / 2 + dot(seen, right) * perUnit,
    y: viewport.top + viewport.height / 2 - dot(seen, up) * perUnit,
    depth,
  };
}

// Returns the direction of the ray through a place in the window; its length is not defined.
export function rayThrough(camera: CameraState, x: number, y: number, viewport: Rect): Vec3 {
  const { right, up, back } = axesOf(camera);
  const perPixel = (2 * Math.tan((camera.fov * Math.PI) / 360)) / viewport.height;
  const across = (x - viewport.left - viewport.width / 2) * perPixel;
  const above = (viewport.top + viewport.height / 2 - y) * perPixel;
  return add(sub(scale(right, across), back), scale(up, above));
}

// Returns the distance at which a ball of this radius fills the picture.
export function distanceFor(radius: number, fov: number, aspect: number): number {
  const half = (fov * Math.PI) / 360;
  const narrow = Math.atan(Math.tan(half) * Math.min(1, aspect));
  return radius / Math.sin(narrow);
}

// The whole ball is in front of the far plane, and as much as depth allows behind the near one, which moves with the
// camera when it is close.
export function nearFar(position: Vec3, target: Vec3, centre: Vec3, radius: number): { near: number; far: number } {
  const away = length(sub(position, centre));
  const far = (away + radius) * 1.01;
  const near = Math.max((away - radius) * 0.99, Math.min(0.02 * length(sub(position, target)), 0.1 * far), far * 1e-6);
  return { near, far };
}

// From the front, slightly aside and from above; of its mirror images the first from which `sees` what is to be seen.
export function wholeView(centre: Vec3, radius: number, up: Vec3, fov: number, aspect: number, sees: (from: Vec3) => boolean = () => true): Pick<CameraState, "position" | "target" | "up"> {
  const [front, side] = up[1] > 0.5 ? ([[0, 0, 1], [1, 0, 0]] as Vec3[]) : ([[0, -1, 0], [1, 0, 0]] as Vec3[]);
  const away = distanceFor(radius, fov, aspect);
  const from = mirrored.map(([toFront, aside, above]) => {
    const toward = unit(add(add(scale(front!, toFront), scale(side!, 0.6 * aside)), scale(up, 0.5 * above)));
    return add(centre, scale(toward, away));
  });
  return { position: from.find(sees) ?? from[0]!, target: centre, up };
}

const mirrored: Vec3[] = [[1, 1, 1], [1, -1, 1], [-1, 1, 1], [-1, -1, 1], [1, 1, -1], [1, -1, -1], [-1, 1, -1], [-1, -1, -1]];

export const kViews: Record<string, Vec3> = {
  "+x": [1, 0, 0],
  "-x": [-1, 0, 0],
  "+y": [0, 1, 0],
  "-y": [0, -1, 0],
  "+z": [0, 0, 1],
  "-z": [0, 0, -1],
};

export interface WitnessPair {
  point: Vec3;
  nearest: Vec3;
}

// Returns a pose from which two points are seen, with some surface around them (`context`: a share of the mesh). Takes the
// first direction that is not blocked, preferring those across the segment, so that it is not seen as a dot, and those near
// the current one.
export function witnessView(
  { point, nearest }: WitnessPair,
  current: Pick<CameraState, "position" | "target" | "up" | "fov">,
  options: { aspect: number; context: number; isFree: (from: Vec3, at: Vec3) => boolean },
): Pick<CameraState, "position" | "target" | "up"> {
  const middle = mix(point, nearest, 0.5);
  const segment = unit(sub(nearest, point));
  const radius = Math.max(2 * length(sub(nearest, point)), options.context);
  const distance = distanceFor(radius, current.fov, options.aspect);
  const now = unit(sub(current.position, current.target));
  const liking = (d: Vec3): number => 0.5 * dot(d, now) - Math.abs(dot(d, segment)) - 0.3 * Math.max(0, Math.abs(dot(d, current.up)) - 0.8);
  const ranked = directions().sort((a, b) => liking(b) - liking(a));
  const free = ranked.find((d) => {
    const eye = add(middle, scale(d, distance));
    return options.isFree(eye, point) && options.isFree(eye, nearest);
  });
  const chosen = free ?? ranked.find((d) => options.isFree(add(middle, scale(d, distance)), point)) ?? ranked[0]!;
  return { position: add(middle, scale(chosen, distance)), target: middle, up: current.up };
}

// Directions evenly around, none exactly along an axis (a spiral of golden angles).
function directions(): Vec3[] {
  const count = 80;
  return Array.from({ length: count }, (_, i) => {
    const z = 1 - (2 * i + 1) / count;
    const turn = i * Math.PI * (3 - Math.sqrt(5));
    const around = Math.sqrt(1 - z * z);
    return [around * Math.cos(turn), around * Math.sin(turn), z];
  });
}

type Pose = Pick<CameraState, "position" | "target">;

// Interpolates two poses: the target moves straight, the camera turns around it, its distance changes by equal factors.
export function flight(from: Pose, to: Pose, share: number): Pose {
  const eased = share * share * (3 - 2 * share);
  const [a, b] = [sub(from.position, from.target), sub(to.position, to.target)];
  const [near, wide] = [length(b), length(a)];
  const reach = wide > 0 && near > 0 ? wide * (near / wide) ** eased : near;
  const target = add(to.target, scale(sub(from.target, to.target), wide > near ? (reach - near) / (wide - near || 1) : 1 - eased));
  return share >= 1 ? to : { position: add(target, scale(turned(unit(a), unit(b), eased), reach)), target };
}

function turned(a: Vec3, b: Vec3, share: number): Vec3 {
  const angle = Math.acos(Math.min(Math.max(dot(a, b), -1), 1));
  if (angle < 1e-6) return unit(mix(a, b, share));
  if (Math.PI - angle < 1e-3) {
    const over = aside(a);
    return share < 0.5 ? turned(a, over, 2 * share) : turned(over, b, 2 * share - 1);
  }
  return unit(add(scale(a, Math.sin((1 - share) * angle)), scale(b, Math.sin(share * angle))));
}
