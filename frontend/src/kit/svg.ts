/** Elements of SVG, without markup strings. */
import { set } from "./dom.ts";

const NS = "http://www.w3.org/2000/svg";

export function shape<K extends keyof SVGElementTagNameMap>(
  parent: SVGElement,
  name: K,
  attributes: Record<string, string | number>,
): SVGElementTagNameMap[K] {
  const element = document.createElementNS<K>(NS, name);
  set(element, attributes);
  parent.append(element);
  return element;
}
