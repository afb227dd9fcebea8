/** The bar on every page: its buttons are for the place that it shows. */
import assert from "node:assert/strict";
import { mock, test } from "node:test";
import { browse } from "./browser.ts";
import { queuePlace, settled, stub } from "./helpers.ts";
import { barPlaces, currentPlaces, isIdle, type QueuePlace } from "../src/queue/person_socket.ts";

const NOW = Date.now();
const place = (robot: string, ticket: number, more: Partial<QueuePlace>): QueuePlace =>
  queuePlace({ robot, name: robot, ticket, ended_ms: NOW, ...more });
const offer = place("mercury", 1, { state: "offered", until_ms: NOW + 10_000 });
const missed = place("pa10", 2, { state: "missed" });
const turn = place("irat", 3, { state: "operating", until_ms: NOW + 60_000 });
const over = place("pa10", 4, { state: "ended", turn: 9, end: { why: "Staff ended it.", credited: "Only the 5 s count.", next: "" } });

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

const document = browse('<aside id="turnbar"><form></form></aside>');
const bar = document.getElementById("turnbar")!;
document.hasFocus = () => true;
stub({
  WebSocket: Socket,
  location: document.location,
  addEventListener: () => undefined,
  performance: { now: () => Date.now() },
  ResizeObserver: class {
    observe(): void {}
  },
});

test("an offer past its end is not shown any more, nor is a turn on its own page", () => {
  assert.deepEqual(currentPlaces([offer, missed], NOW), [offer, missed]);
  assert.deepEqual(currentPlaces([offer, missed], NOW + 10_000), [missed]);
  assert.deepEqual(barPlaces([turn, offer], "irat"), [offer]);
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
  assert.deepEqual(barPlaces([offer, idle], "irat"), [idle, offer], "first what is urgent");
});

test("while somebody drives, what can wait is not shown beside it", () => {
  for (const place of [missed, over, { ...offer, state: "waiting" } as QueuePlace]) {
    assert.deepEqual(barPlaces([place, turn], "irat"), []);
    assert.deepEqual(barPlaces([place], "irat"), [place], "but before and after it");
  }
});

test("a button is for the place that the bar shows, also when an offer before it has run out", async () => {
  mock.timers.enable({ apis: ["setTimeout", "setInterval", "Date"], now: NOW });
  await import("../src/queue/turn_bar.ts");
  Socket.last.onmessage?.({ data: JSON.stringify({ t: "places", now_ms: NOW, places: [offer, missed] }) });
  const press = (wanted: string): void => {
    const button = bar.querySelector<HTMLElement>(`.turnbar-do [data-do=ask-${wanted}]`);
    assert.ok(button, `the bar shows ${wanted}`);
    button.click();
  };
  const words = (): string => bar.querySelector(".turnbar-words b")?.textContent ?? "";
  assert.equal(words(), "It is your turn on mercury");
  mock.timers.tick(10_500);
  assert.match(words(), /^You missed your turn on pa10/);
  press("dismiss");
  assert.deepEqual(Socket.last.sent.at(-1), { t: "do", what: "dismiss", robot: "pa10", ticket: 2 });
});

test("who does nothing is asked at the head of the page, and answers by a button", async () => {
  Socket.last.onmessage?.({ data: JSON.stringify({ t: "answer", to: "dismiss", robot: "pa10", ok: true, text: "" }) });
  await settled(); // until the bar has taken the answer
  const told = (idle_ms: number | null): void =>
    Socket.last.onmessage?.({ data: JSON.stringify({ t: "places", now_ms: Date.now(), places: [{ ...turn, idle_ms }] }) });
  const texts = (): string => [...bar.querySelector(".turnbar-words")!.children].map(({ textContent }) => textContent).join(" ");
  told(Date.now() + 40_000);
  assert.equal(texts().includes("nothing was done"), false);
  told(Date.now() + 20_000);
  assert.equal(texts(), "Your turn on irat ends in 20 s because nothing was done.");
  assert.equal(bar.dataset["state"], "idle");
  mock.timers.tick(5000);
  assert.match(texts(), /ends in 15 s/);
  Socket.last.sent = [];
  document.dispatchEvent(new Event("farhand:acted"));
  assert.deepEqual(Socket.last.sent, [{ t: "look" }], "after a command the places are asked for again");
  const button = bar.querySelector<HTMLElement>(".turnbar-do button");
  assert.equal(button?.textContent, "I'm here");
  button?.click();
  assert.deepEqual(Socket.last.sent.at(-1), { t: "do", what: "stay", robot: "irat", ticket: 3 });
  told(null);
  assert.equal(bar.dataset["state"], "operating");
});

test("how a turn ended is told with what it cost, until it is dismissed", () => {
  Socket.last.onmessage?.({ data: JSON.stringify({ t: "places", now_ms: Date.now(), places: [over] }) });
  const words = bar.querySelector(".turnbar-words b")!.textContent!;
  assert.match(words, /^Your turn on pa10 ended at .*\. Staff ended it\. Only the 5 s count\.$/);
  assert.equal(bar.querySelector(".turnbar-do a")?.getAttribute("href"), "/turns/9/");
});
