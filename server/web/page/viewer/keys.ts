// Keys of the picture, and the dialog that lists them: one table for both.
import type { Commands } from "./commands";
import { button, make } from "./dom";
import { other, type Store } from "./settings";
import type { Stage } from "./stage";

interface KeyHelp {
  keys: string;
  does: string;
}

const kKeyHelp: readonly KeyHelp[] = [
  { keys: "Arrows", does: "turn" },
  { keys: "Shift and arrows", does: "move" },
  { keys: "+ and -", does: "closer, farther" },
  { keys: "0", does: "see everything" },
  { keys: "1 to 6", does: "look from +x, -x, +y, -y, +z, -z" },
  { keys: "w, Shift and w", does: "fly to the witness, to the one of the other direction" },
  { keys: "s", does: "swap A and B" },
  { keys: "d", does: "side by side" },
  { keys: "b", does: "show or hide the mesh that lies over the other" },
  { keys: "x", does: "show edges" },
  { keys: "p", does: "plain colours" },
  { keys: "c", does: "cut across x, y, z, the view, not at all" },
  { keys: "[ and ]", does: "move the cut" },
  { keys: "f", does: "show the other side of the cut" },
  { keys: "?", does: "this list" },
];

const kTurn = 6; // degrees
const kMove = 0.06; // of the picture's height
const kCloser = 1.15;
const kCutStep = 0.02;
const kArrows: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const kViewNames = ["+x", "-x", "+y", "-y", "+z", "-z"];

export function listenToKeys(stage: Stage, store: Store, commands: Commands, help: () => void): void {
  const plain: Record<string, () => void> = {
    "+": () => stage.eye.zoom(kCloser),
    "=": () => stage.eye.zoom(kCloser),
    "-": () => stage.eye.zoom(1 / kCloser),
    "0": () => commands.whole(),
    w: () => void commands.witness(store.value.witness),
    W: () => void commands.nextWitness(),
    s: () => commands.swap(),
    d: () => commands.toggle("split"),
    b: () => commands.show(other(store.value.coloured)),
    x: () => commands.toggle("wire"),
    p: () => commands.toggle("plain"),
    c: () => commands.nextCut(),
    f: () => commands.flipCut(),
    "[": () => commands.moveCut(-kCutStep),
    "]": () => commands.moveCut(kCutStep),
    "?": help,
  };
  stage.canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = kArrows[event.key];
    const view = kViewNames[Number(event.key) - 1];
    const does = plain[event.key];
    if (arrow && event.shiftKey) stage.eye.pan(arrow[0] * kMove, arrow[1] * kMove);
    else if (arrow) stage.eye.orbit(arrow[0] * kTurn, arrow[1] * kTurn);
    else if (view) commands.view(view);
    else if (does) does();
    else return;
    event.preventDefault();
  });
}

// The list of keys, as a dialog.
export function makeHelp(): HTMLDialogElement {
  const dialog = make("dialog", { class: "viewer-help", attributes: { "aria-label": "Keys of the viewer" } });
  const list = make("dl");
  for (const { keys, does } of kKeyHelp) list.append(make("dt", { text: keys }), make("dd", { text: does }));
  dialog.append(
    make("h3", { text: "Keys, while the picture has the focus" }),
    list,
    make("p", { text: "Mouse: drag to turn, right button or Shift to move, wheel to come closer. Touch: one finger turns, two move and zoom." }),
    button("Close", "Close (Escape)", () => dialog.close()),
  );
  return dialog;
}
