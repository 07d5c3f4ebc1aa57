// The explanation of a damaged link.
import type { Linked } from "../route.js";

export function damagedWords(of: Linked, id: string): string {
  const digits = id.toLowerCase().replace(/[^0-9a-f]/g, "").length;
  const whole = `A link to a ${of} ends in 32 characters, each a digit or a letter from a to f.`;
  if (digits === id.length && digits < 32) return `${whole} This one has ${String(digits)}: the rest was cut off on its way here. Copy all of it once more.`;
  return `${whole} This one ends in something else: copy it once more.`;
}
