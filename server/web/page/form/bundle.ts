// Combines the files of a glTF into the archive that the service makes of them, byte for byte (api/formats/gltf_bundle.h), so that a
// mesh has the same SHA-256 however it is sent.

export interface Entry {
  path: string;
  content: Blob;
}

const sceneName = "scene.gltf";
const mostBytes = 2 ** 32 - 1;
const pieceBytes = 4 * 1024 * 1024; // read at a time

/** null: the archive would be larger than 4 GiB. */
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
