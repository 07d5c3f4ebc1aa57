// The types of openapi.yaml. openapi-typescript makes "openapi" from it; only the type checker reads that file.
import type { components } from "openapi";

type Schemas = components["schemas"];

export type Options = Schemas["Options"];
export type Tolerance = Schemas["Tolerance"];
export type Direction = Schemas["Direction"];
export type Strategy = Schemas["Strategy"];
/** The service says what is wrong with the options. */
export type StoredPair = Omit<Schemas["StoredPair"], "options"> & { options: Record<string, unknown> };
export type StoredMesh = Schemas["Mesh"];
export type Job = Schemas["Job"];
export type ProgressEvent = Schemas["ProgressEvent"];
export type Comparison = Schemas["Comparison"];
export type Directed = Schemas["Directed"];
export type MeshFacts = Schemas["MeshFacts"];
export type AreaBounds = Schemas["AreaBounds"];
export type Distribution = Schemas["Distribution"];
export type Stage = Schemas["Stage"];
export type Batch = Schemas["Batch"];
export type BatchCounts = Schemas["BatchCounts"];
export type BatchFailure = Schemas["BatchFailure"];
export type BatchResult = Schemas["BatchResult"];
export type BatchProgressEvent = Schemas["BatchProgressEvent"];
export type JobState = Schemas["JobState"];
export type Timings = Comparison["timings_ms"];
export type Status = Comparison["status"];
export type Verdict = NonNullable<Comparison["verdict"]>;

/** The schema Problem. Its table of types may grow: a page older than its service shows the problem as it is. */
export interface Problem {
  type: string;
  title: string;
  status: number;
  detail: string;
  errors: Schemas["Problem"]["errors"];
}

export type Side = "a" | "b";
export type Vec3 = [number, number, number];

export function hasEnded(one: Job | Batch): boolean {
  return one.state !== "queued" && one.state !== "running";
}
