/** Parts of a page that are made in the background: asked for again until they have arrived, without a reload. */
import { request } from "../kit/request.ts";

const FIRST_MS = 1000, LONGEST_MS = 10_000, SLOWER = 1.4;

/** How long to wait before the part is asked for once more (ms). `moved`: there was news the last time. */
export function pauseAfter(pauseMs: number, moved: boolean): number {
  return moved ? FIRST_MS : Math.min(LONGEST_MS, pauseMs * SLOWER);
}

/** The hidden fields that differ in every answer. Those that the page has are as good as new ones. */
const TOKENS = new Set(["csrfmiddlewaretoken", "once", "press"]);

export function isToken(type: string, name: string): boolean {
  return type === "hidden" && TOKENS.has(name);
}

/** How much it matters that a node stays: above all what somebody has the focus on, or presses. */
function weight(node: Node): number {
  if (!(node instanceof Element)) return 1;
  if (node.matches(":active, :focus-within")) return 10_000;
  return node.id ? 100 : 10;
}

function alike(a: Node, b: Node): boolean {
  return a.nodeName === b.nodeName && (a as Element).id === (b as Element).id;
}

export interface Kinds<T> { alike(a: T, b: T): boolean; weight(one: T): number }

/** Which of `fresh` takes the place of which of `old`: both in their order, so that nothing that stays is moved. */
export function pairs<T>(old: readonly T[], fresh: readonly T[], kinds: Kinds<T>): Map<T, T> {
  const best = Array.from({ length: old.length + 1 }, () => new Array<number>(fresh.length + 1).fill(0));
  const at = (i: number, j: number): number => best[i]?.[j] ?? 0;
  const both = (i: number, j: number): number => {
    const a = old[i] as T;
    return kinds.alike(a, fresh[j] as T) ? at(i + 1, j + 1) + kinds.weight(a) : -1;
  };
  for (let i = old.length - 1; i >= 0; i--)
    for (let j = fresh.length - 1; j >= 0; j--) (best[i] as number[])[j] = Math.max(at(i + 1, j), at(i, j + 1), both(i, j));
  const found = new Map<T, T>();
  for (let i = 0, j = 0; i < old.length && j < fresh.length; ) {
    if (both(i, j) === at(i, j)) found.set(fresh[j++] as T, old[i++] as T);
    else if (at(i + 1, j) === at(i, j)) i++;
    else j++;
  }
  return found;
}

/** Make `old` like `fresh`, and tell whether it was not. What is alike stays as it is, with focus, press and reading position. */
export function adopt(old: Element, fresh: Element): boolean {
  if (old.isEqualNode(fresh) || (old instanceof HTMLInputElement && isToken(old.type, old.name))) return false;
  let moved = false;
  for (const { name } of [...old.attributes]) if (!fresh.hasAttribute(name)) old.removeAttribute(name), (moved = true);
  for (const { name, value } of fresh.attributes) if (old.getAttribute(name) !== value) old.setAttribute(name, value), (moved = true);
  const wanted = [...fresh.childNodes], known = [...old.childNodes];
  const stays = pairs<Node>(known, wanted, { alike, weight }), kept = new Set(stays.values());
  for (const gone of known) if (!kept.has(gone as Node)) gone.remove(), (moved = true);
  let next = old.firstChild;
  for (const one of wanted) {
    const now = stays.get(one);
    if (!now) old.insertBefore(one, next), (moved = true);
    else {
      next = now.nextSibling;
      if (now instanceof Element) moved = adopt(now, one as Element) || moved;
      else if (now.nodeValue !== one.nodeValue) (now.nodeValue = one.nodeValue), (moved = true);
    }
  }
  return moved;
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
