/** Elements of the page: found by id, and written only where something differs. */

/** The element with that id. Throws an error if there is none. */
// eslint-disable-next-line @typescript-eslint/no-unnecessary-type-parameters -- which element it is only its caller knows
export function byId<T extends Element = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (element === null) throw new Error(`no element ${id}`);
  return element as unknown as T;
}

/** Set the text where it differs. */
export function say(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** Set what differs: an attribute that is written again, with the value that it has, is laid out and painted again. */
export function set(element: Element, attributes: Record<string, string | number>): void {
  for (const [key, value] of Object.entries(attributes)) {
    const words = String(value);
    if (element.getAttribute(key) !== words) element.setAttribute(key, words);
  }
}
