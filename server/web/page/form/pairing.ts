// Groups files that were dropped or chosen together into meshes: a .gltf and the files that its buffers name are one mesh.
import { bundle, type Entry } from "./bundle.js";

export interface Meshes {
  files: File[];
  complaint: string; // about a missing file; "": none
}

const mostSceneBytes = 256 * 1024 * 1024; // of JSON that is parsed
const scenes = /\.gltf$/i;
const meshes = /\.(obj|stl|ply|off|glb|3mf|xyz|zip)(\.gz)?$|\.gltf\.gz$/i;

/** True if pairUp() has anything to do. */
export function hasScene(files: readonly File[]): boolean {
  return files.some(({ name }) => scenes.test(name));
}

/** Keeps the order of the files. Files that belong to no mesh are left out, such as textures. */
export async function pairUp(files: readonly File[]): Promise<Meshes> {
  const others = files.filter(({ name }) => !scenes.test(name));
  const found: File[] = [];
  for (const file of files) {
    if (meshes.test(file.name)) found.push(file);
    if (!scenes.test(file.name)) continue;
    const mesh = await completed(file, others);
    if (typeof mesh === "string") return { files: [], complaint: mesh };
    found.push(mesh);
  }
  return { files: found, complaint: "" };
}

// The .gltf with its files; unchanged if it names none, or none that may be sent: the service then reports the error.
async function completed(scene: File, others: readonly File[]): Promise<File | string> {
  const paths = scene.size > mostSceneBytes ? [] : pathsIn(await scene.text());
  const entries: Entry[] = [];
  for (const path of new Set(paths)) {
    const name = path.split("/").at(-1);
    const matching = others.filter((file) => file.name === name);
    if (matching.length === 0) return `${scene.name} names the file “${path}”: drop or choose both together, or a .zip of them.`;
    if (matching.length > 1) return `Several of these files are called “${name ?? ""}”: take one mesh at a time, or a .zip of each.`;
    entries.push(...matching.map((content) => ({ path, content })));
  }
  if (entries.length === 0) return scene;
  return (await bundle(scene, entries)) ?? `${scene.name} and its files are larger than 4 GiB together.`;
}

/** Returns the relative paths that the buffers of a .gltf name; empty if one of them is not such a path. */
export function pathsIn(json: string): string[] {
  const paths = urisIn(json).map(pathOf);
  return paths.every((path) => path !== null) ? paths : [];
}

function urisIn(json: string): string[] {
  let document: unknown;
  try {
    document = JSON.parse(json.replace(/^\uFEFF/, ""));
  } catch {
    return [];
  }
  const { buffers } = (typeof document === "object" && document !== null ? document : {}) as { buffers?: unknown };
  return (Array.isArray(buffers) ? (buffers as unknown[]) : []).flatMap((buffer) => {
    const { uri } = (typeof buffer === "object" && buffer !== null ? buffer : {}) as { uri?: unknown };
    return typeof uri === "string" && uri !== "" && !uri.startsWith("data:") ? [uri] : [];
  });
}

// As file_path_of_uri() of api/formats/file_path.h.
function pathOf(uri: string): string | null {
  let name: string;
  try {
    name = decodeURIComponent(uri.replace(/%(?![0-9a-f]{2})/gi, "%25"));
  } catch {
    return null; // not UTF-8
  }
  const components = name.split("/").filter((component) => component !== "" && component !== ".");
  const leads = name.startsWith("/") || name.endsWith("/") || name.includes("\\") || /^[a-z][a-z0-9+.-]*:/i.test(name);
  return leads || components.length === 0 || components.includes("..") ? null : components.join("/");
}
