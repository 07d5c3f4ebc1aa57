// A deviation map in PLY, as the service sends it: binary and little-endian.
const sizes = { float: 4, double: 8, uchar: 1, uint: 4, int: 4 };
const readers = {
  float: (view, at) => view.getFloat32(at, true), double: (view, at) => view.getFloat64(at, true),
  uchar: (view, at) => view.getUint8(at), uint: (view, at) => view.getUint32(at, true), int: (view, at) => view.getInt32(at, true),
};

function headOf(text) {
  const head = { comments: [], elements: [] };
  for (const line of text.split("\n")) {
    const [word, ...rest] = line.trim().split(" ");
    if (word === "comment") head.comments.push(rest.join(" "));
    if (word === "element") head.elements.push({ name: rest[0], count: Number(rest[1]), properties: [] });
    if (word === "property") head.elements.at(-1).properties.push(rest);
  }
  return head;
}

// {points: [[x, y, z]], distances, colours: [[r, g, b]], triangles: [[a, b, c]], comments}
export function parsePly(buffer) {
  const bytes = new Uint8Array(buffer), mark = "end_header\n";
  const text = new TextDecoder("latin1").decode(bytes.subarray(0, 65536));
  const end = text.indexOf(mark) + mark.length;
  if (!text.startsWith("ply\nformat binary_little_endian") || end < mark.length) throw new Error("not the PLY that was asked for");
  const { elements, comments } = headOf(text.slice(0, end));
  const view = new DataView(buffer), [vertex, face] = elements;
  let at = end;
  const read = (type) => {
    const value = readers[type](view, at);
    at += sizes[type];
    return value;
  };
  const map = { points: [], distances: [], signed: [], colours: [], triangles: [], comments };
  for (let i = 0; i < vertex.count; ++i) {
    const row = Object.fromEntries(vertex.properties.map(([type, name]) => [name, read(type)]));
    map.points.push([row.x, row.y, row.z]);
    map.distances.push(row.distance);
    map.signed.push(row.signed_distance);
    map.colours.push([row.red, row.green, row.blue]);
  }
  const [, countType, indexType] = face.properties[0];
  for (let i = 0; i < face.count; ++i) map.triangles.push(Array.from({ length: read(countType) }, () => read(indexType)));
  if (at !== bytes.length) throw new Error(`the PLY has ${bytes.length - at} bytes too many`);
  return map;
}
