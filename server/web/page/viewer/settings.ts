// The state that the toolbar, the keys and the scale change and the picture shows.
import type { ColourScale, Path } from "./colours";
import type { DeviationMap } from "./map";
import type { Vec3 } from "./vec";

export type Side = "a" | "b";
export const other = (side: Side): Side => (side === "a" ? "b" : "a");
export const nameOf = (side: Side): string => side.toUpperCase();

// The paths of colours that the map is drawn by.
export const pathsOf = (map: Pick<DeviationMap, "sides">): readonly Path[] => (map.sides ? ["outside", "inside"] : ["plain"]);

// What is drawn at a point of a mesh.
export interface Shown {
  distance: number;
  path: Path; // "outside" also where no side is proved
  proved: boolean; // so is the side
}

// `weights`: of the triangle's corners.
export function shownAt({ sides, distances, indices }: Pick<DeviationMap, "sides" | "distances" | "indices">, { triangle, weights }: { triangle: number; weights: Vec3 }): Shown {
  const sum = (value: (vertex: number) => number): number => weights.reduce((all, w, k) => all + w * value(indices[3 * triangle + k]!), 0);
  const signed = sum((v) => (sides?.[v] ?? 0) * distances[v]!);
  return { distance: sum((v) => distances[v]!), path: !sides ? "plain" : signed < 0 ? "inside" : "outside", proved: signed !== 0 };
}

// A point at least `lower` away from the other mesh.
export interface Witness {
  from: Side;
  point: Vec3;
  nearest: Vec3; // that of a side is not known: the point itself
  lower: number;
  upper: number;
  triangle: number;
  nearestTriangle: number;
}

export interface ViewerInput {
  a: DeviationMap; // coloured by its distance to B
  b: DeviationMap; // coloured by its distance to A
  measured?: Side[]; // the meshes whose distance to the other was asked for; by default both
  limit: number | null;
  sideLimits?: ColourScale["sideLimits"];
  units: string;
  witnesses: Witness[]; // one per direction; the first belongs to the verdict
  up?: "y" | "z"; // the axis that points up in such files; z by default
}

export type CutAxis = "off" | "x" | "y" | "z" | "view";

export interface Settings {
  coloured: Side; // the other one lies over it
  shown: Record<Side, boolean>;
  opacity: number; // of the other one, 0 to 1
  wire: boolean;
  plain: boolean; // colours without lighting
  split: boolean; // side by side, each coloured
  cut: { axis: CutAxis; normal: Vec3; offset: number; flipped: boolean }; // offset: -1 to 1, of the radius
  brush: { low: number; high: number } | null; // distances
  witness: number;
  up: "y" | "z";
}

// The side of the verdict's witness is coloured: the limit is exceeded there, if at all.
export const initialSettings = ({ witnesses, up }: Pick<ViewerInput, "witnesses" | "up">): Settings => ({
  coloured: witnesses[0]?.from ?? "a",
  shown: { a: true, b: true },
  opacity: 0.25,
  wire: false,
  plain: false,
  split: false,
  cut: { axis: "off", normal: [1, 0, 0], offset: 0, flipped: false },
  brush: null,
  witness: 0,
  up: up ?? "z",
});

// Observable settings: set() notifies all listeners. Read `value` at any time.
export class Store {
  private readonly listeners = new Set<(settings: Settings) => void>();

  constructor(private now: Settings) {}

  get value(): Settings {
    return this.now;
  }

  set(change: Partial<Settings>): void {
    this.now = { ...this.now, ...change };
    for (const listener of this.listeners) listener(this.now);
  }

  // Also calls the listener at once.
  watch(listener: (settings: Settings) => void): void {
    this.listeners.add(listener);
    listener(this.now);
  }
}
