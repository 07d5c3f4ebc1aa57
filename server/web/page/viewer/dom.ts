// Creates elements without markup in strings, so that Trusted Types have nothing to refuse.

type Child = Node | string;
interface Options {
  class?: string;
  text?: string;
  attributes?: Record<string, string>;
}

export function make<K extends keyof HTMLElementTagNameMap>(tag: K, options: Options = {}, children: Child[] = []): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  if (options.class) element.className = options.class;
  if (options.text !== undefined) element.textContent = options.text;
  for (const [name, value] of Object.entries(options.attributes ?? {})) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

export function makeSvg(tag: string, attributes: Record<string, string | number> = {}): SVGElement {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  return element;
}

// `label`: for screen readers, where the text does not suffice.
export function button(text: string, title: string, press: () => void, label?: string): HTMLButtonElement {
  const made = make("button", { text, attributes: { type: "button", title, ...(label === undefined ? {} : { "aria-label": label }) } });
  made.addEventListener("click", press);
  return made;
}

export function group(label: string, children: Child[]): HTMLElement {
  const made = make("div", { class: "viewer-group", attributes: { role: "group", "aria-label": label } });
  made.append(make("span", { class: "viewer-group-name", text: label, attributes: { "aria-hidden": "true" } }), ...children);
  return made;
}

export const setPressed = (element: Element, pressed: boolean): void => element.setAttribute("aria-pressed", String(pressed));

// Announcements for screen readers. A repeated text is announced again.
export class LiveRegion {
  readonly element = make("div", { class: "viewer-unseen", attributes: { "aria-live": "polite", role: "status" } });

  say(text: string): void {
    this.element.textContent = this.element.textContent === text ? `${text}\u00a0` : text;
  }
}
