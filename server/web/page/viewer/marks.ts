// The witness in the picture: a disc at the point, a square on its tip at the nearest point of the other mesh, and the segment
// between them. Constant in size and above everything; an end hidden by the surface is an outline.
import { BufferAttribute, BufferGeometry, DoubleSide, GLSL3, Mesh, ShaderMaterial, Vector3 } from "three";
import { axesOf, project, type CameraState, type Projected, type Rect, type WitnessPair } from "./camera";
import { kMarkFragment, kMarkVertex } from "./shaders";
import { dot, mix, sub, type Vec3 } from "./vec";

export const kMarkColour = "#ff00ff"; // as in the witness of the files; not in the colour map
const kReach = 11; // CSS pixels from the middle of a mark to the edge of its square

export interface Ends {
  pair: WitnessPair;
  hidden: { point: boolean; nearest: boolean };
}

// In CSS pixels within the window.
export interface MarkPlace {
  left: number;
  right: number;
  y: number;
}

// The part of a segment in front of the near plane; empty if all of it is behind.
export function beforeCamera(camera: CameraState, a: Vec3, b: Vec3): [Vec3, Vec3] | undefined {
  const { back } = axesOf(camera);
  const depth = (p: Vec3): number => -dot(sub(p, camera.position), back) - camera.near;
  const [da, db] = [depth(a), depth(b)];
  if (da <= 0 && db <= 0) return undefined;
  const at = mix(a, b, da / (da - db));
  return [da > 0 ? a : at, db > 0 ? b : at];
}

export class Marks {
  readonly mesh: Mesh;
  private readonly positions = new BufferAttribute(new Float32Array(3 * 12), 3);
  private readonly locals = new BufferAttribute(new Float32Array(3 * 12), 3);
  private readonly material: ShaderMaterial;

  constructor() {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.positions);
    geometry.setAttribute("local", this.locals);
    geometry.setIndex([0, 1, 2].flatMap((quad) => [0, 1, 2, 2, 1, 3].map((i) => 4 * quad + i)));
    this.material = new ShaderMaterial({
      uniforms: { mark: { value: new Vector3(1, 0, 1) }, pixel: { value: 1 } },
      vertexShader: kMarkVertex,
      fragmentShader: kMarkFragment,
      glslVersion: GLSL3,
      transparent: true,
      depthTest: false,
      depthWrite: false,
      forceSinglePass: true,
      side: DoubleSide,
    });
    this.mesh = new Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 10;
  }

  // Updates the marks; returns their place in the picture, undefined if they are not in front of the camera.
  update(camera: CameraState, viewport: Rect, ends: Ends, pixel: number): MarkPlace | undefined {
    this.material.uniforms.pixel!.value = pixel;
    const { point, nearest } = ends.pair;
    this.segment(camera, viewport, point, nearest);
    const alone = point.every((x, k) => x === nearest[k]); // of a side no nearest point is known
    if (alone) this.quad(1, viewport, [], 2);
    else this.disc(1, camera, viewport, nearest, ends.hidden.nearest ? 2.5 : 2);
    this.disc(2, camera, viewport, point, ends.hidden.point ? 1.5 : 1);
    this.positions.needsUpdate = this.locals.needsUpdate = true;
    const [p, q] = [project(camera, point, viewport), project(camera, nearest, viewport)];
    if (p.depth <= camera.near || q.depth <= camera.near) return undefined;
    return { left: Math.min(p.x, q.x), right: Math.max(p.x, q.x), y: (p.y + q.y) / 2 };
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.material.dispose();
  }

  private segment(camera: CameraState, viewport: Rect, a: Vec3, b: Vec3): void {
    const seen = beforeCamera(camera, a, b);
    if (!seen) return this.quad(0, viewport, [], 0);
    const [p, q] = seen.map((end) => project(camera, end, viewport)) as [Projected, Projected];
    const size = Math.hypot(q.x - p.x, q.y - p.y) || 1;
    const [nx, ny] = [(-4 * (q.y - p.y)) / size, (4 * (q.x - p.x)) / size];
    this.quad(0, viewport, [
      [p.x + nx, p.y + ny, 0, 4],
      [p.x - nx, p.y - ny, 0, -4],
      [q.x + nx, q.y + ny, 0, 4],
      [q.x - nx, q.y - ny, 0, -4],
    ], 0);
  }

  private disc(quad: number, camera: CameraState, viewport: Rect, at: Vec3, kind: number): void {
    const { x, y, depth } = project(camera, at, viewport);
    if (depth <= camera.near) return this.quad(quad, viewport, [], kind);
    const corners = [[-1, -1], [1, -1], [-1, 1], [1, 1]].map(([i, j]) => [x + kReach * i!, y + kReach * j!, kReach * i!, kReach * j!]);
    this.quad(quad, viewport, corners, kind);
  }

  // Corners: x and y in the window, x and y within the mark. Empty: nothing is drawn.
  private quad(quad: number, viewport: Rect, corners: number[][], kind: number): void {
    for (let i = 0; i < 4; ++i) {
      const [x, y, u, v] = corners[i] ?? [NaN, NaN, 0, 0];
      const ndc: Vec3 = corners[i]
        ? [(2 * (x! - viewport.left)) / viewport.width - 1, 1 - (2 * (y! - viewport.top)) / viewport.height, 0]
        : [2, 2, 0];
      this.positions.setXYZ(4 * quad + i, ...ndc);
      this.locals.setXYZ(4 * quad + i, u!, v!, kind);
    }
  }
}

// True if the surface is between the eye and the point, with some margin, since the point lies on the surface or near
// to it.
export function hiddenBy(first: (origin: Vec3, direction: Vec3, to: number) => boolean, eye: Vec3, point: Vec3, slack: number): boolean {
  const way = sub(point, eye);
  const size = Math.hypot(...way);
  return size > slack && first(eye, way, 1 - slack / size);
}
