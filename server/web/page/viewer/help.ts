// The list of keys, as a dialog.
import { button, make } from "./dom";
import { kKeyHelp } from "./keys";

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
