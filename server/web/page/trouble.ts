// A problem on the page: what is wrong, where, and what to do.
import { button, h } from "./dom.js";
import { explain, type Defect, type Explained } from "./text/problems.js";

export interface Ways {
  again?: (() => void) | undefined;
  look?: (() => void) | undefined; // the work goes on and only has to be watched again
  form?: (() => void) | undefined;
}

/** Shows the problem in `host` as an alert; returns its explanation. */
export function showTrouble(host: HTMLElement, error: unknown, ways: Ways): Explained {
  const explained = explain(error);
  const title = h(ways.form ? "h1" : "h2", { tabindex: "-1" }, explained.title); // the form has a heading of its own
  const box = h(
    "div",
    { class: "trouble", role: "alert" },
    title,
    explained.detail === "" ? null : h("p", {}, explained.detail),
    explained.defects.length === 0 ? null : h("ul", { class: "defects" }, ...explained.defects.map(defect)),
    explained.advice === "" ? null : h("p", { class: "advice" }, explained.advice),
    h(
      "div",
      { class: "actions" },
      explained.retry && ways.again ? button("Try again", { class: "primary" }, ways.again) : null,
      explained.retry && ways.look ? button("Look again", { class: "primary" }, ways.look) : null,
      ways.form ? button("Back to the form", {}, ways.form) : null,
    ),
    explained.requestId === null ? null : h("p", { class: "hint" }, "For support, the request's id: ", h("code", {}, explained.requestId)),
  );
  host.replaceChildren(box);
  title.focus({ preventScroll: true });
  box.scrollIntoView({ block: "nearest" });
  return explained;
}

function defect(one: Defect): HTMLElement {
  const where = one.where === "" || one.message.includes(one.where) ? "" : ` (${one.where})`;
  return h("li", {}, one.label === "" ? null : h("b", {}, `${one.label}: `), one.message + where);
}
