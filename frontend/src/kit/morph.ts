/** Changes elements until they equal others; what is alike stays, with focus, press and reading position. */
import { set } from "./dom.ts";

/** The hidden fields that differ in every answer; the page's own ones are as good as new ones. */
const TOKENS = new Set(["csrfmiddlewaretoken", "once", "press"]);

export function isToken(type: string, name: string): boolean {
  return type === "hidden" && TOKENS.has(name);
}

/** Return how much it matters that a node stays: most of all one that has the focus or is pressed. */
function weight(node: Node): number {
  if (!(node instanceof Element)) return 1;
  if (node.matches(":active, :focus-within")) return 10_000;
  return node.id ? 100 : 10;
}

function alike(a: Node, b: Node): boolean {
  return a.nodeName === b.nodeName && (a as Element).id === (b as Element).id;
}

export interface Comparison<T> {
  alike(a: T, b: T): boolean;
  weight(one: T): number;
}

/**
 * Return for each of `fresh` the one of `old` that stays in its place: the common subsequence of the greatest weight, so
 * that nothing that stays is moved.
 */
export function align<T>(old: readonly T[], fresh: readonly T[], kinds: Comparison<T>): Map<T, T> {
  const best = Array.from({ length: old.length + 1 }, () => new Array<number>(fresh.length + 1).fill(0));
  const at = (i: number, j: number): number => best[i]![j]!;
  const both = (i: number, j: number): number => (kinds.alike(old[i]!, fresh[j]!) ? at(i + 1, j + 1) + kinds.weight(old[i]!) : -1);
  for (let i = old.length - 1; i >= 0; i--)
    for (let j = fresh.length - 1; j >= 0; j--) best[i]![j] = Math.max(at(i + 1, j), at(i, j + 1), both(i, j));
  const found = new Map<T, T>();
  for (let i = 0, j = 0; i < old.length && j < fresh.length;) {
    if (both(i, j) === at(i, j)) found.set(fresh[j++]!, old[i++]!);
    else if (at(i + 1, j) === at(i, j)) i++;
    else j++;
  }
  return found;
}

/** Change `old` until it equals `fresh`, whose new children it takes over. Tokens of forms stay as they are. */
export function morph(old: Element, fresh: Element): void {
  if (old.isEqualNode(fresh) || (old instanceof HTMLInputElement && isToken(old.type, old.name))) return;
  for (const name of old.getAttributeNames()) if (!fresh.hasAttribute(name)) old.removeAttribute(name);
  set(old, Object.fromEntries([...fresh.attributes].map(({ name, value }) => [name, value])));
  const wanted = [...fresh.childNodes],
    stays = align<Node>([...old.childNodes], wanted, { alike, weight }),
    kept = new Set(stays.values());
  for (const gone of [...old.childNodes]) if (!kept.has(gone)) gone.remove();
  let next = old.firstChild;
  for (const one of wanted) {
    const now = stays.get(one);
    next = now ? now.nextSibling : next;
    if (!now) old.insertBefore(one, next);
    else if (now instanceof Element) morph(now, one as Element);
    else if (now.nodeValue !== one.nodeValue) now.nodeValue = one.nodeValue;
  }
}
