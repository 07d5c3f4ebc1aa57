// Files dropped anywhere on the page.
import { find } from "../dom.js";

/** `take` gets files dropped outside of the two mesh slots; `open` returns whether files are accepted now. */
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
