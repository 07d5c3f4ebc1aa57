// What users must know about the picture, in sentences.
import { count } from "./figures";
import { nameOf, type Side, type ViewerInput } from "./settings";

export function noteOn(side: Side, input: ViewerInput): string | undefined {
  const { display, indices, cloud } = input[side];
  const shown = indices.length / 3;
  const name = nameOf(side);
  if (cloud) {
    const part = display.form === "decimated" ? `; ${count(shown)} are shown. The numbers are of all` : "";
    return `${name} is a point cloud of ${count(display.vertices)} points${part}.`;
  }
  if (display.form === "decimated") {
    return `${name} has ${count(display.triangles)} triangles; ${count(shown)} are shown. The numbers are of the whole mesh.`;
  }
  if (display.form === "refined") {
    return `${name} has ${count(display.triangles)} triangles, refined for display to ${count(shown)}, so that colours show what lies between its vertices.`;
  }
  if (shown === 0) return `${name} has no triangles to show.`;
  return undefined;
}

export function notesOf(input: ViewerInput): string[] {
  const notes = (["a", "b"] as Side[]).map((side) => noteOn(side, input)).filter((note) => note !== undefined);
  if (input.a.noSides) notes.push(`A has no sides of B: ${input.a.noSides.replace("the baseline", "B")}.`);
  return [...notes, "Colours are computed at vertices, not certified; the interval is."];
}
