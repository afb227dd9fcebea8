/** Keeps the focus in place when its element disappears: it moves to the heading of that part, not to the top of the page. */

const HEADINGS = "h1, h2, h3, .turnbar-words";

let last: Element | null = null; // the element that had the focus
let around: Element[] = []; // its ancestors, the nearest first; a removed element has none

function noted(element: Element | null): void {
  last = element;
  around = [];
  for (let box = element?.parentElement; box; box = box.parentElement) around.push(box);
}

/** Return the next place for the focus: the part that `data-then` of an ancestor names, or the first heading that is shown. */
function next(): HTMLElement | null {
  for (const box of around) {
    const named = document.getElementById((box as HTMLElement).dataset["then"] ?? "");
    if (named?.checkVisibility()) return named.querySelector<HTMLElement>(HEADINGS) ?? named;
    if (!box.isConnected || !box.checkVisibility()) continue;
    for (const heading of box.querySelectorAll<HTMLElement>(HEADINGS)) if (heading.checkVisibility()) return heading;
  }
  return null;
}

function look(): void {
  const { activeElement } = document;
  if (!last || (activeElement && activeElement !== document.body && activeElement !== last)) return;
  if (last.isConnected && !last.closest("[hidden]")) return;
  const to = next();
  noted(null);
  if (!to) return;
  if (!to.matches("a[href], button, input, select, textarea, [tabindex]")) to.tabIndex = -1;
  to.focus({ preventScroll: true });
}

document.addEventListener("focusin", (event) => noted(event.target as Element));
// a press elsewhere leaves the element; a second press on the element itself brings no `focusin`
document.addEventListener("pointerdown", ({ target }) => last?.contains(target as Node) || noted(null), { capture: true });
new MutationObserver(look).observe(document, { subtree: true, childList: true, attributeFilter: ["hidden"] });
