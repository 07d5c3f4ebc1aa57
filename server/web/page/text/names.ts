// Makes names from files or users safe to show: visible, and without effect on the text beside them.

const overrides = /[\u202A-\u202E\u2066-\u2069]/g; // change the direction of the text that follows
const visible = /[^\s\p{C}\p{Z}\p{M}]/u;

/** Null if nothing visible is left. */
export function seenName(name: string | null): string | null {
  return name !== null && visible.test(name) ? name : null;
}

export const capital = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

/** For text that continues after the name. */
export function withoutOverrides(text: string): string {
  return text.replace(overrides, "");
}
