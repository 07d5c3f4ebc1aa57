// Places a label beside a segment: to its right or left, else below or above it; never cut by the picture's edge.
import type { Rect } from "./camera";
import type { MarkPlace } from "./marks";

const kGap = 16; // CSS pixels from the marks
const kEdge = 4; // CSS pixels from the picture's edge

// The label's left side and vertical middle, in CSS pixels of the window.
export function labelPlace({ left, right, y }: MarkPlace, picture: Rect, size: { width: number; height: number }): { x: number; y: number } {
  const [first, last] = [picture.left + kEdge, picture.left + picture.width - kEdge - size.width];
  const [top, bottom] = [picture.top + kEdge + size.height / 2, picture.top + picture.height - kEdge - size.height / 2];
  const within = (value: number, from: number, to: number): number => Math.max(from, Math.min(value, to));
  const beside = [right + kGap, left - kGap - size.width].find((x) => x >= first && x <= last);
  if (beside !== undefined) return { x: beside, y: within(y, top, bottom) };
  const below = y + kGap + size.height / 2;
  return { x: within((left + right - size.width) / 2, first, last), y: within(below <= bottom ? below : y - kGap - size.height / 2, top, bottom) };
}
