// What a user can take away: the link, the document, the maps, and the same measurement for a pipeline.
import type { Comparison, Side } from "../api/types.js";
import { button, h, type Attributes } from "../dom.js";
import { asSentence, explain } from "../text/problems.js";
import { checkCommand, curlCommand, gatesYaml, optionsOf, type Names } from "../text/snippets.js";

/** `path`: of the page. `of`: "comparison" or "batch". */
export function linkRow(path: string, expires: string | null, of = "result"): HTMLElement {
  const link = h("input", { id: "link", readonly: true, value: location.origin + path, spellcheck: "false" });
  link.addEventListener("focus", () => link.select());
  const until = expires === null ? null : h("p", { class: "hint" }, `Kept until ${new Date(expires).toLocaleString()}. If the service uses keys, only the same key can open it.`);
  return h("div", { class: "link-row" }, h("label", { for: "link" }, `Link to this ${of}`), h("div", { class: "joined" }, link, copyButton("Copy link", () => link.value)), until);
}

/** Shows for a moment whether copying worked. */
export function copyButton(label: string, text: () => string): HTMLButtonElement {
  const made = button(label, { class: "copy" }, () => void press());
  const press = async () => {
    made.textContent = (await copy(text())) ? "Copied" : "Select it and copy";
    setTimeout(() => (made.textContent = label), 2000);
  };
  return made;
}

// navigator.clipboard is missing on plain http away from localhost.
async function copy(text: string): Promise<boolean> {
  const clipboard = navigator.clipboard as Clipboard | undefined;
  if (clipboard) return clipboard.writeText(text).then(() => true, () => byHand(text));
  return byHand(text);
}

function byHand(text: string): boolean {
  const area = h("textarea", { class: "unseen", "aria-hidden": "true" });
  area.value = text;
  document.body.append(area);
  area.select();
  const done = document.execCommand("copy");
  area.remove();
  return done;
}

/** Saves bytes of the page as a file. */
export function save(name: string, blob: Blob): void {
  const url = URL.createObjectURL(blob);
  const link = h("a", { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

export function jsonButton(result: Comparison): HTMLButtonElement {
  return button("Result as JSON", {}, () => {
    const text = JSON.stringify(result, null, 2) + "\n";
    save(`comparison-${result.id.slice(0, 8)}.json`, new Blob([text], { type: "application/json" }));
  });
}

export function pipeline(result: Comparison, names: Names, withKey: boolean): HTMLElement {
  const origin = location.origin;
  return h(
    "div",
    {},
    h("p", {}, "Run the same check in a pipeline: the build fails when the limit is exceeded."),
    snippet("gates.yaml", gatesYaml(result, names)),
    snippet("Check it, measured by this service", checkCommand(origin)),
    snippet("The same request by curl", curlCommand(origin, names, optionsOf(result), withKey)),
  );
}

function snippet(title: string, text: string): HTMLElement {
  const code = h("pre", { tabindex: 0, role: "region", "aria-label": title }, h("code", {}, text));
  return h("div", { class: "snippet" }, h("div", { class: "snippet-head" }, h("h3", {}, title), copyButton("Copy", () => text)), code);
}

/** "candidate" and "baseline" if the names are unknown. */
export function fallbackNames(result: Comparison): Record<Side, string> {
  return { a: `candidate.${result.meshes.a.format}`, b: `baseline.${result.meshes.b.format}` };
}

export interface Download {
  name: string;
  doing: string; // shown while it lasts
  note: HTMLElement; // shows progress and outcome
  ask: () => Promise<Response>;
}

/** A button that requests a file and saves it. */
export function downloadButton(label: string, attributes: Attributes, { name, doing, note, ask }: Download): HTMLButtonElement {
  const made = button(label, attributes, () => void press());
  const press = async () => {
    made.disabled = true;
    note.textContent = doing;
    try {
      save(name, await (await ask()).blob());
      note.textContent = "";
    } catch (error) {
      const explained = explain(error);
      note.textContent = asSentence(explained.detail || explained.title);
    } finally {
      made.disabled = false;
      if (document.activeElement === document.body) made.focus({ preventScroll: true }); // a disabled button loses the focus
    }
  };
  return made;
}
