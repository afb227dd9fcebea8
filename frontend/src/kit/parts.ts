/** Draws parts of a page again without replacing what stays, so that presses, focus and reading position stay. */
import { say, set } from "./dom.ts";

export interface Part {
  tag: "h2" | "p" | "a" | "button" | "b" | "span";
  text: string;
  class?: string;
  href?: string;
  /** For a button: what a press does. */
  do?: string;
  /** A countdown, which is not announced to screen readers every second. */
  timer?: boolean;
  /** For a button: why it does not work now; place and focus stay. */
  why?: string;
  pressed?: boolean;
}

function identity(p: Part): string {
  return [p.tag, p.do, p.href, p.class, p.timer].join("|");
}

const identities = new WeakMap<Element, string>();

/** Show the parts in the box: an element of the same kind, action and address is kept and gets its new text. */
export function show(box: Element, parts: readonly Part[]): void {
  let next = box.firstElementChild;
  const wanted = new Set(parts.map(identity));
  const skip = (): void => {
    while (next && !wanted.has(identities.get(next) ?? "")) {
      const gone = next;
      next = next.nextElementSibling;
      gone.remove();
    }
  };
  for (const part of parts) {
    skip();
    if (next && identities.get(next) === identity(part)) {
      update(next as HTMLElement, part);
      next = next.nextElementSibling;
    } else box.insertBefore(made(part), next);
  }
  while (next) {
    const gone = next;
    next = next.nextElementSibling;
    gone.remove();
  }
}

function made(part: Part): HTMLElement {
  const element = document.createElement(part.tag);
  identities.set(element, identity(part));
  if (part.class) element.className = part.class;
  if (part.href) (element as HTMLAnchorElement).href = part.href;
  if (part.timer) element.setAttribute("role", "timer");
  if (part.do) {
    element.dataset["do"] = part.do;
    (element as HTMLButtonElement).type = "button";
    element.classList.add("button");
  }
  update(element, part);
  return element;
}

function update(element: HTMLElement, part: Part): void {
  say(element, part.text);
  if (part.do) allow(element, part.why ?? "");
  if (part.pressed !== undefined) element.setAttribute("aria-pressed", String(part.pressed));
}

/** Enable a control, or disable it with a reason, which is shown when it is pressed. Place and focus stay. */
export function allow(control: HTMLElement, why: string): void {
  set(control, { "aria-disabled": String(why !== ""), "data-why": why });
}

/** Why a control is disabled; empty if it is enabled. */
export function refusal(control: HTMLElement): string {
  return control.getAttribute("aria-disabled") === "true" ? control.dataset["why"] || "That does not work now." : "";
}

/** Put exactly these elements into the box, in this order; elements in the right place are not touched. */
export function arrange(box: Element, elements: readonly Element[]): void {
  const wanted = new Set(elements);
  for (const child of [...box.children]) if (!wanted.has(child)) child.remove();
  elements.forEach((element, i) => {
    if (box.children[i] !== element) box.insertBefore(element, box.children[i] ?? null);
  });
}

/** Write rows of words into a table's body; the first cell of each row is its heading. */
export function fill(body: HTMLTableSectionElement, rows: readonly (readonly string[])[]): void {
  if (body.rows.length !== rows.length)
    body.replaceChildren(...rows.map((cells) => {
      const row = document.createElement("tr");
      row.append(...cells.map((_, i) => {
        const cell = document.createElement(i ? "td" : "th");
        if (!i) cell.scope = "row";
        return cell;
      }));
      return row;
    }));
  rows.forEach((cells, i) => cells.forEach((words, k) => {
    const cell = body.rows[i]?.cells[k];
    if (cell) say(cell, words);
  }));
}
