/** Elements of the page: found by id, created with attributes, and written only where something differs. */

const SVG = "http://www.w3.org/2000/svg";
type Attributes = Record<string, string | number>;

/** Return the element with that id. Throws an error if there is none. */
// eslint-disable-next-line @typescript-eslint/no-unnecessary-type-parameters -- which element it is only its caller knows
export function byId<T extends Element = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (element === null) throw new Error(`no element ${id}`);
  return element as unknown as T;
}

/** Tell whether lines run from right to left there. */
export function isRightToLeft(element: Element): boolean {
  return getComputedStyle(element).direction === "rtl";
}

/** Set the text where it differs. */
export function say(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** Write the items of a list where they differ. */
export function sayLines(list: Element, lines: readonly string[]): void {
  while (list.children.length > lines.length) list.lastElementChild?.remove();
  lines.forEach((text, i) => say(list.children[i] ?? list.appendChild(make("li")), text));
}

/** Set the attributes that differ: the browser lays out and paints again even for a value that stays the same. */
export function set(element: Element, attributes: Attributes): void {
  for (const [key, value] of Object.entries(attributes)) {
    const words = String(value);
    if (element.getAttribute(key) !== words) element.setAttribute(key, words);
  }
}

/** Create an element of HTML with attributes and children. */
export function make<K extends keyof HTMLElementTagNameMap>(
  name: K,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(name);
  set(element, attributes);
  element.append(...children);
  return element;
}

/** Create an element of SVG with attributes, and append it to `parent`. */
export function shape<K extends keyof SVGElementTagNameMap>(parent: SVGElement, name: K, attributes: Attributes): SVGElementTagNameMap[K] {
  const element = document.createElementNS<K>(SVG, name);
  set(element, attributes);
  parent.append(element);
  return element;
}
