/** Parts of a page that are made in the background: asked for again until they have arrived, without a reload. */
import { request } from "./request.ts";

const FIRST_MS = 1000, LONGEST_MS = 10_000, SLOWER = 1.4;

/** How long to wait before the part is asked for once more (ms). `moved`: there was news the last time. */
export function pauseAfter(pauseMs: number, moved: boolean): number {
  return moved ? FIRST_MS : Math.min(LONGEST_MS, pauseMs * SLOWER);
}

/** Make `old` like `fresh`. What is the same already stays as it is, so focus, reading position and live regions do. */
export function adopt(old: Element, fresh: Element): boolean {
  if (old.isEqualNode(fresh)) return false;
  for (const { name } of [...old.attributes]) if (!fresh.hasAttribute(name)) old.removeAttribute(name);
  for (const { name, value } of fresh.attributes) if (old.getAttribute(name) !== value) old.setAttribute(name, value);
  const wanted = [...fresh.childNodes], known = [...old.childNodes];
  wanted.forEach((next, at) => {
    const now = known[at];
    if (!now) old.append(next);
    else if (now.nodeName !== next.nodeName) now.replaceWith(next);
    else if (now instanceof Element && next instanceof Element) adopt(now, next);
    else if (now.nodeValue !== next.nodeValue) now.nodeValue = next.nodeValue;
  });
  for (const gone of known.slice(wanted.length)) gone.remove();
  return true;
}

/** Ask for the page again while a part of it has still to arrive. */
export function follow(): void {
  let pauseMs = FIRST_MS, timer = 0, asking = false;
  const parts = (): HTMLElement[] => [...document.querySelectorAll<HTMLElement>("[data-arrives]")];
  const later = (moved: boolean): void => {
    pauseMs = pauseAfter(pauseMs, moved);
    clearTimeout(timer);
    if (parts().length) timer = window.setTimeout(() => void ask(), pauseMs);
  };
  const ask = async (): Promise<void> => {
    if (asking || document.hidden || !parts().length) return;
    asking = true;
    let moved = false;
    try {
      const answer = await request(location.href, { headers: { Accept: "text/html" } });
      if (answer.ok) {
        const fresh = new DOMParser().parseFromString(await answer.text(), "text/html");
        for (const part of parts()) {
          const next = fresh.getElementById(part.id);
          if (next) moved = adopt(part, document.importNode(next, true)) || moved;
        }
      }
    } catch {
      // no connection: it is asked for again
    }
    asking = false;
    later(moved);
  };
  document.addEventListener("visibilitychange", () => void ask());
  later(true);
}
