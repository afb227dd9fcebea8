/** Makes elements like others, and keeps those that are alike with focus, press and reading position. */

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

export interface Comparison<T> {
  alike(a: T, b: T): boolean;
  weight(one: T): number;
}

/** Which of `fresh` takes the place of which of `old`: both in their order, so that nothing that stays is moved. */
export function align<T>(old: readonly T[], fresh: readonly T[], kinds: Comparison<T>): Map<T, T> {
  const best = Array.from({ length: old.length + 1 }, () => new Array<number>(fresh.length + 1).fill(0));
  const at = (i: number, j: number): number => best[i]?.[j] ?? 0;
  const both = (i: number, j: number): number => {
    const a = old[i] as T;
    return kinds.alike(a, fresh[j] as T) ? at(i + 1, j + 1) + kinds.weight(a) : -1;
  };
  for (let i = old.length - 1; i >= 0; i--)
    for (let j = fresh.length - 1; j >= 0; j--) (best[i] as number[])[j] = Math.max(at(i + 1, j), at(i, j + 1), both(i, j));
  const found = new Map<T, T>();
  for (let i = 0, j = 0; i < old.length && j < fresh.length;) {
    if (both(i, j) === at(i, j)) found.set(fresh[j++] as T, old[i++] as T);
    else if (at(i + 1, j) === at(i, j)) i++;
    else j++;
  }
  return found;
}

/** Make `old` like `fresh`, and tell whether it was not. What is alike stays as it is, with focus, press and reading position. */
export function morph(old: Element, fresh: Element): boolean {
  if (old.isEqualNode(fresh) || (old instanceof HTMLInputElement && isToken(old.type, old.name))) return false;
  let moved = false;
  for (const { name } of [...old.attributes])
    if (!fresh.hasAttribute(name)) {
      old.removeAttribute(name);
      moved = true;
    }
  for (const { name, value } of fresh.attributes)
    if (old.getAttribute(name) !== value) {
      old.setAttribute(name, value);
      moved = true;
    }
  const wanted = [...fresh.childNodes],
    known = [...old.childNodes];
  const stays = align<Node>(known, wanted, { alike, weight }),
    kept = new Set(stays.values());
  for (const gone of known)
    if (!kept.has(gone)) {
      gone.remove();
      moved = true;
    }
  let next = old.firstChild;
  for (const one of wanted) {
    const now = stays.get(one);
    if (!now) {
      old.insertBefore(one, next);
      moved = true;
    } else {
      next = now.nextSibling;
      if (now instanceof Element) moved = morph(now, one as Element) || moved;
      else if (now.nodeValue !== one.nodeValue) {
        now.nodeValue = one.nodeValue;
        moved = true;
      }
    }
  }
  return moved;
}
