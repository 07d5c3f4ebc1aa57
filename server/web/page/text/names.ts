// Names that somebody else gave, so that they can be seen and change nothing beside them.

const overrides = /[\u202A-\u202E\u2066-\u2069]/g; // turn the direction of what follows
const visible = /[^\s\p{C}\p{Z}\p{M}]/u;

/** Null where there is nothing to be seen. */
export function seenName(name: string | null): string | null {
  return name !== null && visible.test(name) ? name : null;
}

/** For text that goes on behind it. */
export function withoutOverrides(text: string): string {
  return text.replace(overrides, "");
}
