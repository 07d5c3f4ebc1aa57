// A refused request as an error: the service's problem (RFC 9457) and what the response's headers add.
import type { Problem } from "./types.js";

export class ProblemError extends Error {
  constructor(
    readonly problem: Problem,
    readonly requestId: string | null,
    readonly retryAfterSeconds: number | null,
  ) {
    super(problem.detail);
    this.name = "ProblemError";
  }

  get kind(): string {
    return kindOf(this.problem);
  }
}

/** No response: the network failed, or the service closed the connection. */
export class NetworkError extends Error {
  constructor(readonly doing: string) {
    super(`there was no answer while ${doing}`);
    this.name = "NetworkError";
  }
}

/** Returns "not-found" for "/problems/not-found", and for "urn:meshgauge:problem:not-found" of a job that version 0.1 stored. */
export function kindOf(problem: Problem): string {
  return problem.type.slice(Math.max(problem.type.lastIndexOf("/"), problem.type.lastIndexOf(":")) + 1);
}

type Header = (name: string) => string | null;

/** Returns the error of a response that is not a success. Without a problem document (HEAD, a proxy) it makes one from the status. */
export function toError(status: number, body: string, header: Header): ProblemError {
  const seconds = Number.parseInt(header("Retry-After") ?? "", 10);
  return new ProblemError(
    parse(body) ?? nameless(status),
    header("X-Request-Id"),
    Number.isFinite(seconds) ? Math.max(1, seconds) : null,
  );
}

function parse(body: string): Problem | null {
  try {
    const value: unknown = JSON.parse(body);
    return isProblem(value) ? value : null;
  } catch {
    return null;
  }
}

function isProblem(value: unknown): value is Problem {
  if (typeof value !== "object" || value === null) return false;
  const { type, title, status, detail, errors } = value as Record<string, unknown>;
  const texts = [type, title, detail].every((one) => typeof one === "string");
  return texts && typeof status === "number" && Array.isArray(errors) && errors.every(isDefect);
}

function isDefect(value: unknown): boolean {
  if (typeof value !== "object" || value === null) return false;
  const { part, where, message } = value as Record<string, unknown>;
  return [part, where, message].every((one) => typeof one === "string");
}

const kinds: Record<number, [string, string]> = {
  401: ["unauthorized", "A key is needed"],
  403: ["forbidden", "The request needs a key that allows it"],
  404: ["not-found", "Not found"],
  413: ["too-large", "A size limit is exceeded"],
  429: ["too-many-requests", "The key or the client's address is at its limit"],
  503: ["overloaded", "The service is at its limit"],
};

function nameless(status: number): Problem {
  const [kind, title] = kinds[status] ?? ["unknown", "The service answered something else"];
  const detail = `the answer had the status ${String(status)} and no more words`;
  return { type: `/problems/${kind}`, title, status, detail, errors: [] };
}
