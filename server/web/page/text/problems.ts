// Explains problems: what happened, in which part, and what to do.
import { kindOf, NetworkError, ProblemError } from "../api/problem.js";
import type { Problem } from "../api/types.js";
import { capital } from "./names.js";

export interface Explained {
  title: string;
  detail: string; // "": the defects say all of it
  advice: string; // "": nothing can be done
  defects: Defect[];
  requestId: string | null;
  retry: boolean; // repeating the request may succeed
}

export interface Defect {
  part: "a" | "b" | "options" | "other";
  label: string; // the part, in words
  where: string;
  message: string;
}

const partLabels: Record<string, string> = { a: "Candidate (A)", b: "Baseline (B)", options: "Settings", body: "Request" };

const advices: Record<string, string> = {
  "unauthorized": "Enter a key of this service.",
  "forbidden": "Ask the service's operator for a key with this scope.",
  "quota-exceeded": "Delete meshes that are not needed any more, or ask for more room.",
  "not-found": "The link may be mistyped, the result may no longer be kept, or it belongs to another key. Measure again to get a new link.",
  "request-timeout": "The connection is slow, or was interrupted. Try again, perhaps with a gzip-compressed file.",
  "too-large": "Send a smaller file or a gzip-compressed one, or ask the service's operator for a higher limit.",
  "unsupported-format": "Export the mesh as OBJ, STL, PLY, OFF, glTF, GLB or 3MF.",
  "unreadable-mesh": "The file is damaged or truncated: export it again, and check the program that wrote it.",
  "empty-mesh": "There is no surface to measure: check the program that wrote the file. A point cloud is measured in one direction: choose “From A to B” under “Direction”.",
  "non-finite-vertex": "Export the mesh again: a coordinate is not a finite number.",
  "index-out-of-range": "The file is inconsistent: export it again, and check the program that wrote it.",
  "coordinate-too-large": "Scale the mesh down: squares of such coordinates no longer fit a floating-point number.",
  "invalid-request": "Correct the setting that is named.",
  "unit-conflict": "Say which unit each mesh and the limit is in.",
  "unknown-mesh": "Choose the file again: the service no longer keeps it.",
  "digest-mismatch": "The file changed while it was sent: choose it again.",
  "internal": "This is a fault of the service. Report it with the request's id.",
  "overloaded": "Try again in a moment.",
  "shutting-down": "Try again in a moment.",
  "too-many-requests": "Wait a moment, then try again.",
  "out-of-time": "Allow more time: under “More settings”.",
  "storage-unavailable": "Try again in a moment. If it persists, the service's operator should check its disk or database.",
  "storage-full": "The service's operator has to free disk space.",
};

const passing = new Set([
  "unauthorized", "overloaded", "shutting-down", "too-many-requests", "storage-unavailable", "storage-full", "request-timeout", "internal", "digest-mismatch",
]);

export function explain(error: unknown): Explained {
  if (error instanceof ProblemError) return explainProblem(error.problem, error.requestId);
  if (error instanceof NetworkError) return unanswered(error);
  const detail = error instanceof Error ? error.message : String(error);
  const none = { defects: [], requestId: null };
  return { title: "The page failed", detail, advice: "Reload the page and try again.", ...none, retry: true };
}

export function explainProblem(problem: Problem, requestId: string | null): Explained {
  const kind = kindOf(problem);
  const defects = problem.errors.map(toDefect);
  const gone = kind === "not-found" && /(comparison|batch) has this id/.exec(problem.detail)?.[1];
  // The service's words for these are meant for programs.
  const repeats = typeof gone === "string" || kind === "unauthorized" || (defects.length === 1 && defects[0]?.message === problem.detail);
  return {
    title: typeof gone === "string" ? `There is no such ${gone}, or it was removed` : problem.title,
    detail: repeats ? "" : asSentence(problem.detail),
    advice: advices[kind] ?? "",
    defects,
    requestId,
    retry: passing.has(kind),
  };
}

/** Makes a sentence: the service's messages start with a small letter and have no full stop. */
export function asSentence(text: string): string {
  if (text === "") return "";
  return `${capital(text)}${/[.?!]$/.test(text) ? "" : "."}`;
}

function toDefect(error: Problem["errors"][number]): Defect {
  const part = error.part === "a" || error.part === "b" || error.part === "options" ? error.part : "other";
  return { part, label: partLabels[error.part] ?? error.part, where: error.where, message: error.message };
}

function unanswered(error: NetworkError): Explained {
  return {
    title: "The service did not answer",
    detail: `The connection broke while ${error.doing}.`,
    advice: "Is the service running, and the network up? A file above the service's limit can also end like this.",
    defects: [],
    requestId: null,
    retry: true,
  };
}
