// What three.js finds in a PLY or a GLB, as JSON: node read_by_three.mjs NODE_MODULES FILE
import { readFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

const [modules, path] = process.argv.slice(2);
const loaders = pathToFileURL(`${modules}/three/examples/jsm/loaders/`);
const bytes = readFileSync(path);
const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);

const list = (attribute, size) => {
  const rows = [];
  for (let i = 0; i < attribute.count; ++i) {
    const row = [];
    for (let k = 0; k < size; ++k) row.push(attribute.getComponent(i, k));
    rows.push(size === 1 ? row[0] : row);
  }
  return rows;
};
const triangles = (index) => {
  const rows = [];
  for (let i = 0; i < index.count; i += 3) rows.push([index.getX(i), index.getX(i + 1), index.getX(i + 2)]);
  return rows;
};
const facts = (geometry) => ({
  positions: list(geometry.attributes.position, 3),
  colours: list(geometry.attributes.color, 3),
  quality: list(geometry.attributes.quality ?? geometry.attributes._distance, 1),
  triangles: triangles(geometry.index),
});

let found;
if (path.endsWith('.ply')) {
  const { PLYLoader } = await import(new URL('PLYLoader.js', loaders));
  const loader = new PLYLoader();
  loader.setCustomPropertyNameMapping({ quality: ['quality'] });
  found = facts(loader.parse(buffer));
} else {
  globalThis.self = globalThis;  // what the loader takes for granted in a browser
  const { GLTFLoader } = await import(new URL('GLTFLoader.js', loaders));
  const gltf = await new GLTFLoader().parseAsync(buffer, '');
  const candidate = gltf.scene.getObjectByName('candidate');
  found = {
    ...facts(candidate.geometry),
    place: candidate.position.toArray(),
    extras: candidate.userData,
    nodes: gltf.scene.children.map((node) => node.name).sort(),
  };
}
process.stdout.write(JSON.stringify(found));
