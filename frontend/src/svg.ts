/** Helpers to draw SVG without markup strings. */
const NS = "http://www.w3.org/2000/svg";

export function shape<K extends keyof SVGElementTagNameMap>(
  parent: SVGElement, name: K, attributes: Record<string, string | number>,
): SVGElementTagNameMap[K] {
  const element = document.createElementNS(NS, name) as SVGElementTagNameMap[K];
  set(element, attributes);
  parent.append(element);
  return element;
}

/** Set what differs: an attribute that is written again, with the value that it has, is laid out and painted again. */
export function set(element: Element, attributes: Record<string, string | number>): void {
  for (const [key, value] of Object.entries(attributes)) {
    const words = String(value);
    if (element.getAttribute(key) !== words) element.setAttribute(key, words);
  }
}

export function byId<T extends Element = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (element === null) throw new Error(`no element ${id}`);
  return element as unknown as T;
}
