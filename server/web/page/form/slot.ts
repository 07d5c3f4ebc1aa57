// The place for one mesh: dropped, chosen, or already stored by the service.
import type { Side } from "../api/types.js";
import { button, complainAt, h } from "../dom.js";
import { inBytes } from "../text/numbers.js";

export type Chosen = { kind: "file"; file: File } | { kind: "stored"; id: string; name: string; bytes: number };

const titles: Record<Side, [string, string]> = {
  a: ["Candidate", "the mesh that is checked"],
  b: ["Baseline", "what it is compared with"],
};

const known = ["obj", "stl", "ply", "off", "gltf", "glb", "3mf", "xyz", "zip"];

/** Returns "STL", "OBJ, gzip-compressed"; null: the name has no extension of a known format. */
export function formatOf(name: string): string | null {
  const parts = name.toLowerCase().split(".");
  const packed = parts.at(-1) === "gz";
  const suffix = parts.at(packed ? -2 : -1) ?? "";
  if (parts.length < 2 || !known.includes(suffix)) return null;
  return suffix.toUpperCase().replace("GLTF", "glTF").replace("ZIP", "glTF, zipped") + (packed ? ", gzip-compressed" : "");
}

export const nameOf = (chosen: Chosen): string => (chosen.kind === "file" ? chosen.file.name : chosen.name);

export class Slot {
  private chosen: Chosen | null = null;
  private readonly input: HTMLInputElement;
  private readonly dropArea: HTMLElement;
  private readonly box = h("div", { class: "slot-box" });
  private readonly error: HTMLElement;

  constructor(
    readonly side: Side,
    private readonly host: HTMLElement,
    private readonly changed: () => void,
    private readonly took: (files: File[]) => void, // called with files that were chosen or dropped for it
  ) {
    const id = `file-${side}`;
    this.error = h("p", { class: "error", id: `${id}-error`, hidden: true });
    this.input = h("input", { type: "file", id, class: "unseen", multiple: true, "aria-describedby": `${id}-error` });
    this.dropArea = h("label", { class: "drop-area", for: id });
    this.input.addEventListener("change", () => {
      const files = [...(this.input.files ?? [])];
      if (files.length > 0) this.took(files);
    });
    this.acceptDrops();
    this.box.append(this.dropArea);
    host.replaceChildren(this.input, this.box, this.error);
    this.draw();
  }

  get value(): Chosen | null {
    return this.chosen;
  }

  choose(chosen: Chosen | null): void {
    this.chosen = chosen;
    if (chosen?.kind !== "file") this.input.value = "";
    this.complain("");
    this.draw();
    this.changed();
  }

  complain(message: string): void {
    complainAt(this.input, this.error, message);
    this.host.classList.toggle("wrong", message !== "");
  }

  focus(): void {
    this.input.focus();
  }

  private acceptDrops(): void {
    this.host.addEventListener("dragover", (event) => {
      event.preventDefault();
      this.host.classList.add("over");
    });
    this.host.addEventListener("dragleave", () => this.host.classList.remove("over"));
    this.host.addEventListener("drop", (event) => {
      this.host.classList.remove("over");
      const files = [...(event.dataTransfer?.files ?? [])];
      if (files.length === 0) return;
      event.preventDefault();
      event.stopPropagation();
      this.took(files);
    });
  }

  private draw(): void {
    const [title, role] = titles[this.side];
    const letter = this.side.toUpperCase();
    const head = h("span", { class: "slot-head" }, h("b", { class: "letter" }, letter), h("span", {}, title), h("small", {}, role));
    this.dropArea.replaceChildren(head, ...(this.chosen ? this.describe(this.chosen) : [this.invitation()]));
    this.host.classList.toggle("full", this.chosen !== null);
    this.box.replaceChildren(this.dropArea, ...(this.chosen ? [this.remover(title)] : []));
  }

  private invitation(): HTMLElement {
    return h("span", { class: "invite" }, h("span", {}, "Drop a file here, or "), h("u", {}, "choose one"));
  }

  private remover(title: string): HTMLButtonElement {
    return button("Remove", { class: "link remove", "aria-label": `Remove the ${title.toLowerCase()}` }, () => {
      this.choose(null);
      this.focus();
    });
  }

  private describe(chosen: Chosen): HTMLElement[] {
    const name = nameOf(chosen);
    const bytes = chosen.kind === "file" ? chosen.file.size : chosen.bytes;
    const format = formatOf(name);
    const kept = chosen.kind === "stored" ? ["kept by the service"] : [];
    const words = [inBytes(bytes), ...(format === null ? [] : [format]), ...kept].join(" · ");
    const rows = [h("span", { class: "file-name" }, name), h("span", { class: "file-facts" }, words)];
    if (chosen.kind === "file" && format === null) {
      rows.push(h("span", { class: "file-note" }, "The name does not say which format this is; the service looks at the content."));
    }
    return rows;
  }
}
