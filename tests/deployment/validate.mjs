// Reads a JSON array of Kubernetes objects and writes a JSON array of what a strict API server would
// refuse: values that the schema does not allow, and fields that it does not know.
//
// The schemas are those of Kubernetes, KEDA and the Prometheus operator, compiled to functions by the packages
// kubernetes-models. They pass over unknown fields, so they get the objects through proxies that note what is looked
// at: a function asks for every field that its schema has, and a field that no function asked for is unknown.
import { existsSync, readFileSync } from "node:fs";

const MODULES = new URL("./node_modules/", import.meta.url);
const PACKAGES = { "keda.sh": "@kubernetes-models/keda", "monitoring.coreos.com": "@kubernetes-models/prometheus-operator" };

// The file of a kind names the file of its schema.
async function validator({ apiVersion, kind }) {
  const folder = new URL(`${PACKAGES[apiVersion.split("/")[0]] ?? "kubernetes-models"}/${apiVersion}/`, MODULES);
  const file = new URL(`${kind}.js`, folder);
  if (!existsSync(file)) return undefined;
  const [, schema] = /import\{validate\}from"([^"]+)"/.exec(readFileSync(file, "utf8"));
  return (await import(new URL(schema, folder))).validate;
}

function watched(value, path, seen) {
  if (typeof value !== "object" || value === null) return value;
  const children = new Map();
  seen.push({ path, value, children });
  return new Proxy(value, {
    get(target, key) {
      if (typeof key === "symbol" || !Object.hasOwn(target, key) || (Array.isArray(target) && key === "length")) return target[key];
      if (!children.has(key)) children.set(key, watched(target[key], `${path}/${key}`, seen));
      return children.get(key);
    },
  });
}

async function complaints(object) {
  const validate = await validator(object);
  if (!validate) return [{ path: "/kind", message: `no ${object.kind} in ${object.apiVersion}` }];
  const seen = [];
  const valid = validate(watched(object, "", seen));
  const wrong = valid ? [] : validate.errors.map((e) => ({ path: e.instancePath, message: `${e.keyword} ${JSON.stringify(e.params)}` }));
  const unknown = seen.flatMap(({ path, value, children }) =>
    Object.keys(value).filter((key) => !children.has(key)).map((key) => ({ path: `${path}/${key}`, message: "unknown field" })));
  return [...wrong, ...unknown];
}

const objects = JSON.parse(readFileSync(0, "utf8"));
const found = [];
for (const [index, object] of objects.entries()) {
  for (const complaint of await complaints(object)) found.push({ index, object: `${object.kind}/${object.metadata?.name}`, ...complaint });
}
console.log(JSON.stringify(found));
