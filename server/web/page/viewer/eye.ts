// The camera's control: OrbitControls for mouse and touch, the same motions for keys, flights. Poses are in the meshes'
// coordinates; three.js gets them relative to the meshes' centre, where single precision is enough.
import { MOUSE, TOUCH, type PerspectiveCamera, type Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { axesOf, distanceFor, flight, kViews, wholeView, type CameraState } from "./camera";
import { add, cross, dot, length, scale, sub, unit, type Vec3 } from "./vec";

export type Pose = Pick<CameraState, "position" | "target" | "up" | "fov">;
type Aim = Pick<CameraState, "position" | "target" | "up">;

const kFov = 35; // of the picture's smaller side, so that a narrow picture shows as much as a wide one
const kFlight = 900; // ms

interface Flight {
  from: Pose;
  to: Aim;
  begun: number;
  landed: () => void;
}

const toVec = (v: Vector3, centre: Vec3): Vec3 => [v.x + centre[0], v.y + centre[1], v.z + centre[2]];

export class Eye {
  private controls: OrbitControls;
  private upName: "y" | "z" = "z";
  private flying?: Flight;
  private fov = kFov;
  private aspect = 1.6;

  constructor(
    private readonly lens: PerspectiveCamera,
    private readonly canvas: HTMLCanvasElement,
    private readonly centre: Vec3,
    private readonly radius: number,
    private readonly changed: () => void,
    private readonly sees: (from: Vec3) => boolean, // what the whole view is to show
  ) {
    lens.up.set(0, 0, 1);
    this.controls = this.makeControls();
    this.whole();
  }

  pose(): Pose {
    return {
      position: toVec(this.lens.position, this.centre),
      target: toVec(this.controls.target, this.centre),
      up: [this.lens.up.x, this.lens.up.y, this.lens.up.z],
      fov: this.fovFor(this.aspect),
    };
  }

  // Vertical angle in degrees.
  fovFor(aspect: number): number {
    return aspect >= 1 ? this.fov : scaledAngle(this.fov, 1 / aspect);
  }

  setPose(pose: Partial<Pose>): void {
    if (pose.fov && pose.fov > 0 && pose.fov < 180) this.fov = scaledAngle(pose.fov, Math.min(1, this.aspect));
    if (pose.up && sub(pose.up, this.pose().up).some((x) => x !== 0)) this.turnUp(pose.up);
    if (pose.target) this.controls.target.set(...sub(pose.target, this.centre));
    if (pose.position) this.lens.position.set(...sub(pose.position, this.centre));
    this.controls.update();
    this.changed();
  }

  // The lens for one part of the canvas, from `camera` and not from the controls, so that the picture matches what is
  // announced.
  aim(camera: CameraState, aspect: number): void {
    this.aspect = aspect;
    this.lens.aspect = aspect;
    this.lens.fov = camera.fov;
    this.lens.near = camera.near;
    this.lens.far = camera.far;
    this.lens.updateProjectionMatrix();
  }

  settings(up: "y" | "z", split: boolean): void {
    this.controls.zoomToCursor = !split; // the pointer's place is relative to the whole canvas
    if (up === this.upName) return;
    this.upName = up;
    this.turnUp(up === "y" ? [0, 1, 0] : [0, 0, 1]);
    this.whole();
  }

  whole(): void {
    this.flying?.landed();
    this.setPose(wholeView(this.centre, this.radius, this.pose().up, this.fov, 1, this.sees));
  }

  // Looks along an axis: '+x' looks from there.
  view(name: string): Promise<void> {
    const away = distanceFor(this.radius, this.fov, 1);
    const toward = kViews[name] ?? kViews["+x"]!;
    return this.flyTo({ position: add(this.centre, scale(toward, away)), target: this.centre, up: this.pose().up });
  }

  // Turns by degrees to the right and up.
  orbit(right: number, up: number): void {
    const pose = this.pose();
    const offset = sub(pose.position, pose.target);
    const turned = aroundAxis(offset, pose.up, (right * Math.PI) / 180);
    const { right: axis } = axesOf({ ...pose, position: add(pose.target, turned) });
    const tilted = aroundAxis(turned, axis, (-up * Math.PI) / 180);
    const overhead = Math.abs(dot(unit(tilted), pose.up)) > 0.9995;
    this.setPose({ position: add(pose.target, overhead ? turned : tilted) });
  }

  // Moves by shares of the picture's height.
  pan(right: number, up: number): void {
    const pose = this.pose();
    const axes = axesOf(pose);
    const height = 2 * Math.tan((pose.fov * Math.PI) / 360) * length(sub(pose.position, pose.target));
    const by = add(scale(axes.right, right * height), scale(axes.up, up * height));
    this.setPose({ position: add(pose.position, by), target: add(pose.target, by) });
  }

  zoom(factor: number): void {
    const pose = this.pose();
    const wanted = length(sub(pose.position, pose.target)) / factor;
    const away = Math.min(Math.max(wanted, this.controls.minDistance), this.controls.maxDistance);
    this.setPose({ position: add(pose.target, scale(unit(sub(pose.position, pose.target)), away)) });
  }

  // Resolves on arrival, or when the user takes over; at once if the user prefers reduced motion.
  flyTo(to: Aim): Promise<void> {
    this.flying?.landed();
    if (window.matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.setPose(to);
      return Promise.resolve();
    }
    return new Promise((resolve) => {
      const landed = (): void => {
        this.flying = undefined;
        resolve();
      };
      this.flying = { from: this.pose(), to, begun: performance.now(), landed };
      this.changed();
    });
  }

  // Makes one step of a flight; false: there is none.
  fly(now: number): boolean {
    const current = this.flying;
    if (!current) return false;
    const share = Math.min(1, (now - current.begun) / kFlight);
    this.setPose(flight(current.from, current.to, share));
    if (share >= 1) current.landed();
    return true;
  }

  dispose(): void {
    this.flying?.landed();
    this.controls.dispose();
  }

  // OrbitControls reads "up" when it is created.
  private turnUp(up: Vec3): void {
    const target = this.controls.target.clone();
    this.controls.dispose();
    this.lens.up.set(...up);
    this.controls = this.makeControls();
    this.controls.target.copy(target);
  }

  private makeControls(): OrbitControls {
    const controls = new OrbitControls(this.lens, this.canvas);
    controls.zoomToCursor = true;
    controls.minDistance = 1e-5 * this.radius;
    controls.maxDistance = 50 * this.radius;
    controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };
    controls.touches = { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN };
    controls.addEventListener("change", () => this.changed());
    controls.addEventListener("start", () => this.flying?.landed());
    return controls;
  }
}

// Returns the angle whose half has a tangent so many times as large.
function scaledAngle(degrees: number, factor: number): number {
  return (360 / Math.PI) * Math.atan(Math.tan((degrees * Math.PI) / 360) * factor);
}

// Rodrigues' rotation.
function aroundAxis(v: Vec3, axis: Vec3, angle: number): Vec3 {
  const k = unit(axis), along = dot(k, v), side = cross(k, v);
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [0, 1, 2].map((i) => v[i]! * c + side[i]! * s + k[i]! * along * (1 - c)) as Vec3;
}
