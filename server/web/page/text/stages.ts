// Names of the stages of a comparison.
import type { JobState, Stage, Timings } from "../api/types.js";

export function stageWords(state: JobState, stage: Stage): string {
  if (state === "queued") return "Waiting for a free worker";
  if (state !== "running") return "Ended";
  return stage === null ? "Reading both meshes" : running[stage];
}

const running: Record<NonNullable<Stage>, string> = {
  build: "Building a tree over each mesh",
  traverse: "Ruling out triangles that cannot matter",
  reduce: "Splitting the triangles that are left",
  certify: "Certifying the interval",
  areas: "Certifying shares of the area",
  statistics: "Sampling the surface",
};

export interface StageTime {
  name: keyof Timings;
  label: string;
  ms: number;
}

const labels: [keyof Timings, string][] = [
  ["queue", "Waiting"],
  ["read_a", "Reading A"],
  ["read_b", "Reading B"],
  ["align", "Aligning"],
  ["build", "Building trees"],
  ["traverse", "Traversal"],
  ["reduce", "Reduction"],
  ["certify", "Certificate"],
  ["areas", "Areas"],
  ["statistics", "Statistics"],
];

/** In order of time, without the total. */
export function stageTimes(timings: Timings): StageTime[] {
  return labels.flatMap(([name, label]) => {
    const ms = timings[name];
    return ms === undefined ? [] : [{ name, label, ms }];
  });
}
