// The form: two meshes, chosen or dropped anywhere on the page, the options, and errors beside the fields that they are about.
import type { Comparison, Side } from "../api/types.js";
import { complainAt, find, h } from "../dom.js";
import { asSentence, type Defect } from "../text/problems.js";
import { exampleFiles } from "./example.js";
import { buildOptions, fieldOf, furtherOf, noValues, valuesOf, type Field, type FormValues, type Json, type Mistake } from "./options.js";
import { hasScene, pairUp } from "./pairing.js";
import { Slot, type Chosen } from "./slot.js";

export type { Chosen } from "./slot.js";

export interface Order {
  a: Chosen;
  b: Chosen;
  options: Json;
}

const inMore: Field[] = ["further", "timeout", "threads", "strategy", "points", "statistics", "align", "unitA", "unitB"];

export class Form {
  private readonly form = find("#form", HTMLFormElement);
  private readonly general = find("#form-error", HTMLElement);
  private readonly slots: Record<Side, Slot>;

  constructor(private readonly ordered: (order: Order) => void) {
    const changed = () => (this.general.textContent = "");
    this.slots = {
      a: new Slot("a", find("#slot-a", HTMLElement), changed, (files) => this.take(files, "a")),
      b: new Slot("b", find("#slot-b", HTMLElement), changed, (files) => this.take(files, "b")),
    };
    find("#swap", HTMLElement).addEventListener("click", () => this.swap());
    find("#example", HTMLElement).addEventListener("click", () => this.takeExample());
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.submit();
    });
    this.form.addEventListener("change", () => this.adapt());
    this.form.addEventListener("input", (event) => {
      if (event.target instanceof HTMLElement && "name" in event.target) this.say(event.target.name as Field, "");
    });
    this.adapt();
  }

  /**
   * Two meshes are A and B as they come; one goes to `side`, else where there is room, else it is a new candidate. A .gltf and
   * the files that it names are one mesh.
   */
  take(files: File[], side: Side | null = null): void {
    if (hasScene(files)) void this.pairUp(files, side);
    else this.place(files, side);
  }

  private async pairUp(files: File[], side: Side | null): Promise<void> {
    const meshes = await pairUp(files).catch(() => ({ files: [], complaint: "These files cannot be read." }));
    if (meshes.complaint === "") return this.place(meshes.files, side);
    this.slots[side ?? this.sideWithRoom()].complain(meshes.complaint);
  }

  private place([first, second]: File[], side: Side | null): void {
    if (first && second) {
      this.slots.a.choose({ kind: "file", file: first });
      this.slots.b.choose({ kind: "file", file: second });
    } else if (first) {
      this.slots[side ?? this.sideWithRoom()].choose({ kind: "file", file: first });
    }
  }

  private sideWithRoom(): Side {
    return this.slots.a.value && !this.slots.b.value ? "b" : "a";
  }

  /** Fills in the pair and the settings of a result, to measure again, with the files of its own order if there is one. */
  again(result: Comparison, names: Record<Side, string>, order: Order | null): void {
    for (const side of ["a", "b"] as const) {
      const { sha256, bytes } = result.meshes[side];
      const stored: Chosen = { kind: "stored", id: sha256, name: names[side], bytes };
      this.slots[side].choose(order?.[side].kind === "file" ? order[side] : stored);
    }
    this.fill(valuesOf(result));
  }

  forget(side: Side): void {
    this.slots[side].choose(null);
  }

  /** Shows the service's defects, each beside the part that it belongs to. */
  blame(defects: Defect[]): void {
    for (const { part, message } of defects) {
      if (part === "a" || part === "b") this.slots[part].complain(message);
    }
    const further = furtherOf(this.values().further) ?? {};
    const ofOptions = defects.filter(({ part }) => part === "options").map(({ where, message }) => [fieldOf(where, further), message] as const);
    for (const [field, message] of ofOptions.reverse()) this.say(field, inField(field, message)); // of several the first stays
  }

  private swap(): void {
    const { a, b } = this.slots;
    const was = a.value;
    a.choose(b.value);
    b.choose(was);
  }

  private takeExample(): void {
    const { a, b } = exampleFiles();
    this.take([a, b]);
    this.fill({ ...this.values(), limit: "1", units: "mm" });
    find("#measure", HTMLElement).focus();
  }

  private values(): FormValues {
    const data = new FormData(this.form);
    const values = Object.entries(noValues).map(([name, none]: [string, string | boolean]) => {
      const value = data.get(name);
      return [name, typeof none === "boolean" ? data.has(name) : typeof value === "string" ? value : none] as const;
    });
    return Object.fromEntries(values) as unknown as FormValues;
  }

  private fill(values: FormValues): void {
    for (const [name, value] of Object.entries(values)) {
      const field = this.form.elements.namedItem(name) as HTMLInputElement | RadioNodeList; // all fields have a value
      if (typeof value === "string") field.value = value;
      else (field as HTMLInputElement).checked = value;
    }
    this.adapt();
  }

  // Shows fields that apply only with a certain choice.
  private adapt(): void {
    const { toleranceKind, strategy } = this.values();
    find("#tolerance-field", HTMLElement).hidden = toleranceKind === "default";
    find("#points-field", HTMLElement).hidden = strategy !== "n_point";
  }

  private submit(): void {
    const built = buildOptions(this.values());
    const { a, b } = this.slots;
    this.clear();
    for (const mistake of built.mistakes) this.say(mistake.field, mistake.message);
    if (!a.value) a.complain("Choose the candidate.");
    if (!b.value) b.complain("Choose the baseline.");
    if (a.value && b.value && built.options) return this.ordered({ a: a.value, b: b.value, options: built.options });
    this.goTo(!a.value ? a : !b.value ? b : null, built.mistakes);
  }

  private clear(): void {
    for (const error of this.form.querySelectorAll<HTMLElement>(".error")) {
      error.textContent = "";
      if (error !== this.general) error.hidden = true;
    }
    for (const wrong of this.form.querySelectorAll("[aria-invalid]")) wrong.removeAttribute("aria-invalid");
  }

  // Focuses the first defect, and shows a general line in case the field is out of view.
  private goTo(slot: Slot | null, mistakes: readonly Mistake[]): void {
    const count = mistakes.length + (slot ? 1 : 0);
    this.general.replaceChildren(h("span", {}, count === 1 ? "One thing is missing or wrong above." : "Some things are missing or wrong above."));
    if (slot) slot.focus();
    else if (mistakes[0]) find(`#${mistakes[0].field}`, HTMLElement).focus();
  }

  private say(field: Field, message: string): void {
    const error = this.form.querySelector<HTMLElement>(`#${field}-error`);
    if (!error) return;
    complainAt(find(`#${field}`, HTMLElement, this.form), error, message);
    if (message !== "" && inMore.includes(field)) find("#more", HTMLDetailsElement).open = true;
  }
}

// A field needs no place: "/gate/max_distance must be a number" is "Must be a number." there.
function inField(field: Field, message: string): string {
  return asSentence(field === "further" ? message : message.replace(/^\/\S+ /, ""));
}

/**
 * Accepts files dropped anywhere on the page. `take` gets those dropped outside of the two mesh slots; `open` returns whether
 * files are accepted now.
 */
export function acceptDrops(take: (files: File[]) => void, open: () => boolean): void {
  const curtain = find("#dropping", HTMLElement);
  let depth = 0; // dragenter and dragleave fire for every element on the way
  const close = () => {
    depth = 0;
    curtain.hidden = true;
  };
  document.addEventListener("dragenter", (event) => {
    if (!open() || !hasFiles(event)) return;
    ++depth;
    curtain.hidden = false;
  });
  document.addEventListener("dragleave", () => {
    if (depth > 0 && --depth === 0) close();
  });
  document.addEventListener("dragover", (event) => {
    if (hasFiles(event)) event.preventDefault();
  });
  document.addEventListener("drop", close, true);
  document.addEventListener("drop", (event) => {
    if (!hasFiles(event)) return;
    event.preventDefault(); // else the browser would open the file instead of the page
    if (open()) take([...(event.dataTransfer?.files ?? [])]);
  });
}

function hasFiles(event: DragEvent): boolean {
  return event.dataTransfer?.types.includes("Files") ?? false;
}
