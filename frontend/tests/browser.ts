/** As much of a browser as elements need, for tests without one. */
import { JSDOM } from "jsdom";

const NAMES = [
  "document",
  "window",
  "Node",
  "Element",
  "HTMLElement",
  "HTMLInputElement",
  "Event",
  "CustomEvent",
  "MutationObserver",
] as const;

/** Give the test's modules a document with this body; import what uses it afterwards. */
export function browse(body = ""): Document {
  const { window } = new JSDOM(`<!doctype html><body>${body}</body>`, { url: "http://localhost/log/", pretendToBeVisual: true });
  for (const name of NAMES)
    Object.defineProperty(globalThis, name, { value: name === "window" ? globalThis : window[name], configurable: true, writable: true });
  return window.document;
}
