// The batch of the README's picture: a library of small parts, of which some wear.
import { begun, ended, stored } from "./browser/batches.mjs";
import { dented, obj, sphere } from "./browser/meshes.mjs";

const names = ["bearing", "bushing", "knob", "float", "plunger", "roller", "valve ball"];

// Waits until the batch has ended.
export async function nightly(service) {
  const drawn = await stored(service, obj(sphere(24)));
  const printed = [];
  for (let wear = 0; wear < 12; ++wear) printed.push(await stored(service, obj(dented(24, 0.004 + 0.006 * wear))));
  const comparisons = Array.from({ length: 240 }, (_, i) => ({
    name: `${names[i % names.length]}-${String(i).padStart(3, "0")}.stl`, a: printed[i % 31 === 7 ? 8 + (i % 4) : i % 8], b: drawn,
    options: { tolerance: { relative: 0.01 + 1e-6 * i } },
  }));
  const cut = await stored(service, Buffer.from("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n"));
  comparisons[100].a = cut;
  const batch = await begun(service, { name: "nightly, release 2.4", options: { gate: { max_distance: 0.05, units: "mm" } }, comparisons });
  await ended(service, batch.id);
  return batch;
}
