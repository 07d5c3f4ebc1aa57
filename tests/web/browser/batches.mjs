// Batches that the tests submit themselves, without the browser.
import { obj, sheet } from "./meshes.mjs";
import { asked } from "./service.mjs";

export const json = (value) => ({ method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(value) });

// The id of a stored mesh.
export async function stored(service, bytes, headers = {}) {
  const answer = await asked(service, "/v1/meshes", { method: "POST", headers: { "Content-Type": "application/octet-stream", ...headers }, body: bytes });
  return (await answer.json()).id;
}

// The unit square at this height.
export const square = (height) => obj(sheet(1, 1, (u, v) => [u, v, height], { closed: false }));

export async function begun(service, manifest, headers = {}) {
  const asking = json(manifest);
  return (await asked(service, "/v1/batches", { ...asking, headers: { ...asking.headers, ...headers } })).json();
}

export const batchAt = async (service, id) => (await asked(service, `/v1/batches/${id}`)).json();

export async function ended(service, id) {
  for (;;) {
    const batch = await batchAt(service, id);
    if (batch.state !== "running") return batch;
    await new Promise((done) => setTimeout(done, 50));
  }
}
