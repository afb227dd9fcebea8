/** The bar on every page: its buttons are for the place that it shows. */
import assert from "node:assert/strict";
import { mock, test } from "node:test";
import { isIdle, type QueuePlace } from "../src/queue/person_socket.ts";
import { currentPlaces, barPlaces } from "../src/queue/places.ts";

const NOW = Date.now();
const place = (robot: string, ticket: number, more: Partial<QueuePlace>): QueuePlace =>
  ({ state: "waiting", ticket, robot, name: robot, ahead: 0, away: false, until_ms: null, kept_until_ms: null, ended_ms: NOW, wait_s: null, idle_ms: null, end: null, turn: null, ...more });
const offer = place("mercury", 1, { state: "offered", until_ms: NOW + 10_000 });
const missed = place("pa10", 2, { state: "missed" });
const turn = place("irat", 3, { state: "operating", until_ms: NOW + 60_000 });
const over = place("pa10", 4, { state: "ended", turn: 9, end: { why: "Staff ended it.", credited: "Only the 5 s count.", next: "" } });

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
const heard = new Map<string, () => void>();
const stubs = {
  window: globalThis,
  WebSocket: Socket,
  location: { protocol: "http:", host: "localhost", href: "http://localhost/log/", pathname: "/log/" },
  addEventListener: () => undefined,
  ResizeObserver: class {
    observe(): void {}
  },
  document: {
    title: "", hidden: false, hasFocus: () => true, body: new Box(), querySelector: () => null,
    documentElement: { style: { setProperty: () => undefined } },
    addEventListener: (name: string, call: () => void) => heard.set(name, call),
    createElement: () => new Box(), getElementById: (id: string) => (id === "turnbar" ? bar : null),
  },
};
for (const [name, value] of Object.entries(stubs)) Object.defineProperty(globalThis, name, { value, configurable: true });

test("an offer past its end is not shown any more, nor is a turn on its own page", () => {
  assert.deepEqual(currentPlaces([offer, missed], NOW), [offer, missed]);
  assert.deepEqual(currentPlaces([offer, missed], NOW + 10_000), [missed]);
  assert.deepEqual(barPlaces([turn, missed], "irat"), [missed]);
  assert.deepEqual(barPlaces([turn, missed], "pa10"), [turn, missed]);
});

test("a turn ends soon only if the server said so within these seconds, and if its page is open", () => {
  const told = (seconds: number, more = {}): boolean => isIdle({ ...turn, idle_ms: NOW + seconds * 1000, ...more }, NOW);
  assert.deepEqual([told(20), told(21), told(19, { kept_until_ms: NOW + 5 }), told(5)], [true, false, false, true]);
  assert.equal(isIdle(turn, NOW), false, "nobody waits for it");
});

test("the robot's own page hides how a turn there ended, which it tells itself, but not that it ends soon", () => {
  assert.deepEqual(barPlaces([over, missed], "pa10"), [missed]);
  assert.deepEqual(barPlaces([{ ...over, turn: null }], "pa10").length, 1, "a lost place is told there too");
  const idle = { ...turn, idles: true };
  assert.deepEqual(barPlaces([missed, idle], "irat"), [idle, missed], "first what is urgent");
});

test("a button is for the place that the bar shows, also when an offer before it has run out", async () => {
  mock.timers.enable({ apis: ["setTimeout", "setInterval", "Date"], now: NOW });
  await import("../src/queue/turn_bar.ts");
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

test("who does nothing is asked at the head of the page, and answers by a button", async () => {
  Socket.last.onmessage?.({ data: JSON.stringify({ t: "answer", to: "dismiss", robot: "pa10", ok: true, text: "" }) });
  for (let i = 0; i < 50; i++) await Promise.resolve(); // until the bar has taken the answer
  const told = (idle_ms: number | null): void =>
    Socket.last.onmessage?.({ data: JSON.stringify({ t: "places", now_ms: Date.now(), places: [{ ...turn, idle_ms }] }) });
  const texts = (): string => shown.children[0]!.children.map(({ textContent }) => textContent).join(" ");
  told(Date.now() + 40_000);
  assert.equal(texts().includes("nothing was done"), false);
  told(Date.now() + 20_000);
  assert.equal(texts(), "Your turn on irat ends in 20 s because nothing was done.");
  assert.equal(bar.dataset["state"], "idle");
  mock.timers.tick(5000);
  assert.match(texts(), /ends in 15 s/);
  Socket.last.sent = [];
  heard.get("farhand:acted")?.();
  assert.deepEqual(Socket.last.sent, [{ t: "look" }], "after a command the places are asked for again");
  const [button] = shown.children[1]!.children;
  assert.equal(button?.textContent, "I'm here");
  shown.children[1]!.click({ target: button });
  assert.deepEqual(Socket.last.sent.at(-1), { t: "do", what: "stay", robot: "irat", ticket: 3 });
  told(null);
  assert.equal(bar.dataset["state"], "operating");
});

test("how a turn ended is told with what it cost, until it is dismissed", () => {
  Socket.last.onmessage?.({ data: JSON.stringify({ t: "places", now_ms: Date.now(), places: [over] }) });
  assert.match(shown.children[0]!.children[0]!.textContent, /^Your turn on pa10 ended at .*\. Staff ended it\. Only the 5 s count\.$/);
  const [page] = shown.children[1]!.children;
  assert.equal((page as unknown as { href: string }).href, "/turns/9/");
});
