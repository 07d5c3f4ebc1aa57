// Buttons and labelled inputs for everything that the picture can do. They always show the current settings.
import { cutWords, type Commands } from "./commands";
import { button, group, make, setPressed } from "./dom";
import { kViews } from "./camera";
import { nameOf, other, type CutAxis, type Side, type Store, type ViewerInput } from "./settings";

interface Actions {
  picture: () => void;
  help: () => void;
}

export function makeToolbar(input: ViewerInput, store: Store, commands: Commands, actions: Actions): HTMLElement {
  const bar = make("div", { class: "viewer-toolbar", attributes: { role: "group", "aria-label": "Viewer" } });
  bar.append(
    witnessGroup(input, store, commands),
    meshGroup(store, commands),
    lookGroup(store, commands),
    cutGroup(store, commands),
    viewGroup(store, commands),
    group("More", [
      button("Picture", "Save the picture as PNG", actions.picture),
      button("Keys", "What the keys do (?)", actions.help),
    ]),
  );
  return bar;
}

function pressed(store: Store, element: HTMLButtonElement, is: () => boolean): HTMLButtonElement {
  store.watch(() => setPressed(element, is()));
  return element;
}

function witnessGroup(input: ViewerInput, store: Store, commands: Commands): HTMLElement {
  const buttons = input.witnesses.map((witness, index) => {
    const [one, two] = [nameOf(witness.from), nameOf(other(witness.from))];
    const made = button(`${one} → ${two}`, `Fly to the witness from ${one} to ${two} (w)`, () => void commands.witness(index), `${one} → ${two}: fly to the witness`);
    return pressed(store, made, () => store.value.witness === index);
  });
  return group("Witness", buttons.length > 0 ? buttons : [make("span", { text: "none" })]);
}

function meshGroup(store: Store, commands: Commands): HTMLElement {
  const shows = (["a", "b"] as Side[]).map((side) => {
    const title = `Show mesh ${nameOf(side)}`;
    return pressed(store, button(nameOf(side), title, () => commands.show(side), title), () => store.value.shown[side]);
  });
  const slider = range("Glass", "Opacity of the mesh over the other", { min: 0.05, max: 1, step: 0.05 }, (opacity) => store.set({ opacity }));
  store.watch(({ opacity, split }) => {
    slider.input.value = String(opacity);
    slider.input.setAttribute("aria-valuetext", `${Math.round(100 * opacity)} %`);
    slider.input.disabled = split;
  });
  return group("Meshes", [
    ...shows,
    button("Swap", "Colour the other mesh (s)", () => commands.swap()),
    pressed(store, button("Side by side", "Both coloured, with linked cameras (d)", () => commands.toggle("split")), () => store.value.split),
    slider.label,
  ]);
}

function lookGroup(store: Store, commands: Commands): HTMLElement {
  return group("Look", [
    pressed(store, button("Edges", "Show the triangles’ edges (x)", () => commands.toggle("wire")), () => store.value.wire),
    pressed(store, button("Plain colours", "Colours as in the scale, without light (p)", () => commands.toggle("plain")), () => store.value.plain),
  ]);
}

const kCuts: Record<CutAxis, string> = { off: "Off", x: "x", y: "y", z: "z", view: "View" };

function cutGroup(store: Store, commands: Commands): HTMLElement {
  const buttons = (Object.keys(kCuts) as CutAxis[]).map((axis) => {
    const made = button(kCuts[axis], `${cutWords(axis)} (c)`, () => commands.cut(axis), axis === "off" ? "Off: no cut" : cutWords(axis));
    return pressed(store, made, () => store.value.cut.axis === axis);
  });
  const slider = range("At", "Place of the cut", { min: -1, max: 1, step: 0.005 }, (offset) => store.set({ cut: { ...store.value.cut, offset } }));
  const flip = pressed(store, button("Flip", "Show the other side (f)", () => commands.flipCut()), () => store.value.cut.flipped);
  store.watch(({ cut }) => {
    slider.input.value = String(cut.offset);
    slider.input.setAttribute("aria-valuetext", placeWords(cut.offset));
    slider.input.disabled = flip.disabled = cut.axis === "off";
  });
  return group("Cut", [...buttons, slider.label, flip]);
}

function placeWords(offset: number): string {
  const percent = Math.round(100 * Math.abs(offset));
  return percent === 0 ? "through the middle" : `${percent} % of the radius ${offset < 0 ? "before" : "beyond"} the middle`;
}

function viewGroup(store: Store, commands: Commands): HTMLElement {
  const from = Object.keys(kViews).map((name, i) => {
    const label = `Look from ${name.replace("+", "plus ").replace("-", "minus ")}`;
    return button(name.replace("-", "−"), `Look from ${name} (${i + 1})`, () => commands.view(name), label);
  });
  const up = make("select", { attributes: { "aria-label": "Axis that points up" } }, [
    make("option", { text: "z up", attributes: { value: "z" } }),
    make("option", { text: "y up", attributes: { value: "y" } }),
  ]);
  up.addEventListener("change", () => store.set({ up: up.value === "y" ? "y" : "z" }));
  store.watch((settings) => (up.value = settings.up));
  return group("View", [button("All", "See everything (0)", () => commands.whole()), ...from, up]);
}

function range(text: string, label: string, ends: { min: number; max: number; step: number }, moved: (value: number) => void): { label: HTMLElement; input: HTMLInputElement } {
  const input = make("input", { attributes: { type: "range", "aria-label": label, min: String(ends.min), max: String(ends.max), step: String(ends.step) } });
  input.addEventListener("input", () => moved(Number(input.value)));
  return { label: make("label", { class: "viewer-range" }, [make("span", { text }), input]), input };
}
