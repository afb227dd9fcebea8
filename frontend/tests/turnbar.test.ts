/** The bar on every page: its buttons are for the place that it shows. */
import assert from "node:assert/strict";
import { mock, test } from "node:test";
import type { Standing } from "../src/person.ts";
import { current, shownOf } from "../src/shown.ts";

const NOW = Date.now();
const place = (robot: string, ticket: number, more: Partial<Standing>): Standing =>
  ({ state: "waiting", ticket, robot, name: robot, ahead: 0, away: false, until_ms: null, kept_until_ms: null, ended_ms: NOW, wait_s: null, ...more });
const offer = place("mercury", 1, { state: "offered", until_ms: NOW + 10_000 });
const missed = place("pa10", 2, { state: "missed" });
const turn = place("irat", 3, { state: "operating", until_ms: NOW + 60_000 });

/** As much of an element as the bar uses. */
class Box {
  hidden = false;
  className = "";
  textContent = "";
  dataset: Record<string, string> = {};
  classList = { add: (): void => undefined };
  children: Box[] = [];
  parent: Box | null = null;
  click: (event: object) => void = () => undefined;
  get firstElementChild(): Box | null {
    return this.children[0] ?? null;
  }
  get nextElementSibling(): Box | null {
    const beside = this.parent?.children ?? [];
    return beside[beside.indexOf(this) + 1] ?? null;
  }
  insertBefore(child: Box, next: Box | null): void {
    child.parent = this;
    this.children.splice(next ? this.children.indexOf(next) : this.children.length, 0, child);
  }
  append(...children: Box[]): void {
    for (const child of children) this.insertBefore(child, null);
  }
  remove(): void {
    this.parent?.children.splice(this.parent.children.indexOf(this), 1);
  }
  addEventListener(_: string, call: (event: object) => void): void {
    this.click = call;
  }
  closest(): Box {
    return this;
  }
  querySelector(): Box | null {
    return form;
  }
  replaceWith(inner: Box): void {
    shown = inner;
  }
  setAttribute(): void {}
  getAttribute(): null {
    return null;
  }
}

class Socket {
  static OPEN = 1;
  static last: Socket;
  readyState = Socket.OPEN;
  sent: Record<string, unknown>[] = [];
  onmessage: ((event: { data: string }) => void) | null = null;
  constructor() {
    Socket.last = this;
  }
  send(text: string): void {
    this.sent.push(JSON.parse(text));
  }
}

let shown = new Box(); // what the bar put in place of the server's form
const bar = new Box(), form = new Box();
form.querySelector = () => null;
const stubs = {
  window: globalThis,
  WebSocket: Socket,
  location: { protocol: "http:", host: "localhost", href: "http://localhost/log/" },
  addEventListener: () => undefined,
  ResizeObserver: class {
    observe(): void {}
  },
  document: {
    title: "", hidden: false, hasFocus: () => true, body: new Box(), addEventListener: () => undefined, querySelector: () => null,
    createElement: () => new Box(), getElementById: (id: string) => (id === "turnbar" ? bar : null),
  },
};
for (const [name, value] of Object.entries(stubs)) Object.defineProperty(globalThis, name, { value, configurable: true });

test("an offer past its end is not shown any more, nor is a turn on its own page", () => {
  assert.deepEqual(current([offer, missed], NOW), [offer, missed]);
  assert.deepEqual(current([offer, missed], NOW + 10_000), [missed]);
  assert.deepEqual(shownOf([turn, missed], "irat"), [missed]);
  assert.deepEqual(shownOf([turn, missed], "pa10"), [turn, missed]);
});

test("a button is for the place that the bar shows, also when an offer before it has run out", async () => {
  mock.timers.enable({ apis: ["setTimeout", "setInterval", "Date"], now: NOW });
  await import("../src/turnbar.ts");
  Socket.last.onmessage?.({ data: JSON.stringify({ t: "places", now_ms: NOW, places: [offer, missed] }) });
  const press = (wanted: string): void => {
    const [, buttons] = shown.children;
    const button = buttons?.children.find((one) => one.dataset["do"] === `ask-${wanted}`);
    assert.ok(button, `the bar shows ${wanted}`);
    buttons?.click({ target: button });
  };
  const words = (): string => shown.children[0]?.children[0]?.textContent ?? "";
  assert.equal(words(), "It is your turn on mercury");
  mock.timers.tick(10_500);
  assert.match(words(), /^You missed your turn on pa10/);
  press("dismiss");
  assert.deepEqual(Socket.last.sent.at(-1), { t: "do", what: "dismiss", robot: "pa10", ticket: 2 });
});
