// Uploads a mesh, unless the service has it. Reports progress, which fetch() cannot.
import type { Client } from "./client.js";
import { NetworkError, ProblemError, toError } from "./problem.js";
import type { StoredMesh } from "./types.js";

export type UploadStep = { step: "hashing" } | { step: "sending"; sent: number; of: number } | { step: "there"; reused: boolean };

const mostHashedBytes = 512 * 1024 * 1024; // subtle.digest needs the whole file in memory

/** Returns the mesh's id. */
export async function store(client: Client, file: File, report: (step: UploadStep) => void, signal: AbortSignal): Promise<string> {
  const id = await hash(file, report);
  if (id !== null && (await isThere(client, id, signal))) {
    report({ step: "there", reused: true });
    return id;
  }
  const stored = await client.withRetries(() => client.authorized(() => transmit(client, file, id, report, signal)), signal);
  report({ step: "there", reused: false });
  return stored.id;
}

// crypto.subtle is missing on plain http away from localhost.
async function hash(file: File, report: (step: UploadStep) => void): Promise<string | null> {
  const subtle = crypto.subtle as SubtleCrypto | undefined;
  if (!subtle || file.size > mostHashedBytes) return null;
  report({ step: "hashing" });
  return hex(await subtle.digest("SHA-256", await file.arrayBuffer()));
}

export function hex(bytes: ArrayBuffer): string {
  return Array.from(new Uint8Array(bytes), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

async function isThere(client: Client, id: string, signal: AbortSignal): Promise<boolean> {
  try {
    await client.sendWithRetries(`/v1/meshes/${id}`, { method: "HEAD", signal, doing: "asking whether the mesh is there" });
    return true;
  } catch (error) {
    if (error instanceof ProblemError && error.problem.status === 404) return false;
    throw error;
  }
}

function transmit(
  client: Client,
  file: File,
  id: string | null,
  report: (step: UploadStep) => void,
  signal: AbortSignal,
): Promise<StoredMesh> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    const stop = () => request.abort();
    request.open(id === null ? "POST" : "PUT", id === null ? "/v1/meshes" : `/v1/meshes/${id}`);
    for (const [name, value] of Object.entries(headersFor(client, file))) request.setRequestHeader(name, value);
    request.upload.onprogress = (event) => report({ step: "sending", sent: event.loaded, of: file.size });
    request.onload = () => {
      if (request.status < 300) resolve(JSON.parse(request.responseText) as StoredMesh);
      else reject(toError(request.status, request.responseText, (name) => request.getResponseHeader(name)));
    };
    request.onerror = () => reject(new NetworkError(`sending ${file.name}`));
    request.onabort = () => reject(new DOMException("stopped", "AbortError"));
    request.onloadend = () => signal.removeEventListener("abort", stop);
    signal.addEventListener("abort", stop, { once: true });
    if (signal.aborted) return void reject(new DOMException("stopped", "AbortError"));
    report({ step: "sending", sent: 0, of: file.size });
    request.send(file);
  });
}

function headersFor(client: Client, file: File): Record<string, string> {
  return {
    ...client.authorization(),
    "Content-Type": file.type || "application/octet-stream",
    "Content-Disposition": disposition(file.name),
  };
}

/** Returns `attachment; filename="..."` in UTF-8, one character per byte as in header values, without control characters. */
export function disposition(name: string): string {
  const shown = Array.from(name, (c) => (c < " " || c === "\x7F" ? "_" : c)).join("");
  const bytes = new TextEncoder().encode(shown.replace(/["\\]/g, "\\$&"));
  return `attachment; filename="${Array.from(bytes, (byte) => String.fromCharCode(byte)).join("")}"`;
}
