// Groups files that were dropped or chosen together into meshes: a .gltf and the files that its buffers name are one mesh, for
// which they become one archive.

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

// As file_path_of_uri() of api/formats/file/file_path.h.
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

export interface Entry {
  path: string;
  content: Blob;
}

const sceneName = "scene.gltf";
const mostBytes = 2 ** 32 - 1;
const pieceBytes = 4 * 1024 * 1024; // read at a time

/**
 * Combines the files of a glTF into the archive that the service makes of them, byte for byte (api/formats/gltf/gltf_bundle.h), so
 * that a mesh has the same SHA-256 however it is sent. null: the archive would be larger than 4 GiB.
 */
export async function bundle(scene: File, files: readonly Entry[]): Promise<File | null> {
  const entries = [...files.map(encoded), encoded({ path: sceneName, content: scene })].sort((a, b) => order(a.name, b.name));
  const bytes = entries.reduce((sum, { name, content }) => sum + 76 + 2 * name.length + content.size, 22);
  if (bytes > mostBytes) return null;
  const parts: BlobPart[] = [];
  const directory: BlobPart[] = [];
  let at = 0;
  let directoryBytes = 0;
  for (const { name, content } of entries) {
    const facts: Field[] = [[20, 2], [0x800, 2], [0, 2], [0, 2], [0x21, 2], [await crc32(content), 4], [content.size, 4], [content.size, 4], [name.length, 2], [0, 2]];
    parts.push(record([[0x04034b50, 4], ...facts]), name, content);
    directory.push(record([[0x02014b50, 4], [20, 2], ...facts, [0, 2], [0, 2], [0, 2], [0, 4], [at, 4]]), name);
    at += 30 + name.length + content.size;
    directoryBytes += 46 + name.length;
  }
  const count: Field = [entries.length, 2];
  const end = record([[0x06054b50, 4], [0, 2], [0, 2], count, count, [directoryBytes, 4], [at, 4], [0, 2]]);
  return new File([...parts, ...directory, end], `${scene.name}.zip`, { type: "application/zip" });
}

function encoded({ path, content }: Entry): { name: Uint8Array<ArrayBuffer>; content: Blob } {
  return { name: new TextEncoder().encode(path), content };
}

// By the bytes of UTF-8, which differs from the order of JavaScript's strings.
function order(a: Uint8Array, b: Uint8Array): number {
  const length = Math.min(a.length, b.length);
  for (let i = 0; i < length; ++i) {
    const difference = (a[i] ?? 0) - (b[i] ?? 0);
    if (difference !== 0) return difference;
  }
  return a.length - b.length;
}

type Field = [value: number, bytes: 2 | 4];

function record(fields: readonly Field[]): Uint8Array<ArrayBuffer> {
  const out = new DataView(new ArrayBuffer(fields.reduce((sum, [, bytes]) => sum + bytes, 0)));
  let at = 0;
  for (const [value, bytes] of fields) {
    if (bytes === 2) out.setUint16(at, value, true);
    else out.setUint32(at, value, true);
    at += bytes;
  }
  return new Uint8Array(out.buffer);
}

const table = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; ++bit) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value;
});

async function crc32(content: Blob): Promise<number> {
  let crc = 0xffffffff;
  for (let at = 0; at < content.size; at += pieceBytes) {
    const piece = new Uint8Array(await content.slice(at, at + pieceBytes).arrayBuffer());
    for (const byte of piece) crc = (crc >>> 8) ^ (table[(crc ^ byte) & 0xff] ?? 0);
  }
  return ~crc >>> 0;
}
