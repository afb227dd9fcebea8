/** The socket to a robot: when it counts as lost, and when it is opened again, on a clock of the test's own. */
import assert from "node:assert/strict";
import { beforeEach, mock, test } from "node:test";
import { settled, stub } from "./helpers.ts";

const OPEN = 1,
  CLOSED = 3;
let now = 0; // ms
let sockets: Socket[] = [];
let reached = true; // whether a server takes connections
let answers = true; // whether it answers those that it takes

/** A browser's socket; the test is the server. */
class Socket {
  static readonly CONNECTING = 0;
  static readonly OPEN = OPEN;
  readyState = 0;
  sent: string[] = [];
  closed = false;
  readonly at = now;
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: string | ArrayBuffer }) => void) | null = null;
  onclose: ((event: { code: number; reason: string }) => void) | null = null;
  readonly url: string;

  constructor(url: string) {
    this.url = url;
    sockets.push(this);
    setTimeout(() => (reached ? answers && this.accept() : this.end(1006)), 1);
  }

  private accept(): void {
    this.readyState = OPEN;
    this.onopen?.();
  }

  send(message: string): void {
    this.sent.push(message);
  }

  say(message: object): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }

  end(code: number): void {
    this.readyState = CLOSED;
    this.onclose?.({ code, reason: "Too many watch." });
  }

  close(): void {
    this.closed = true;
  }
}

let listeners: [string, (event: object) => void][] = [];
const heard = (name: string, listener: (event: object) => void): void => void listeners.push([name, listener]);
const happens = (name: string, event: object = {}): void =>
  listeners.filter(([of]) => of === name).forEach(([, listener]) => listener(event));
stub({
  document: { querySelector: () => null, hidden: false, addEventListener: heard },
  location: { protocol: "http:", host: "robots.example.org" },
  window: globalThis,
  addEventListener: heard,
  WebSocket: Socket,
  performance: { now: () => now },
});
const { HeldMotion } = await import("../src/socket/held_motion.ts");
const { RobotSocket } = await import("../src/socket/robot_socket.ts");

/** Let time go on. */
function pass(ms: number): void {
  for (let left = ms; left > 0; left -= 10) {
    now += 10;
    mock.timers.tick(10);
  }
}

function page(slug = "mercury", said: string[] = [], more: object = {}): InstanceType<typeof RobotSocket> {
  const none = { state: () => undefined, picture: () => undefined, line: () => undefined };
  return new RobotSocket(slug, { ...none, message: (m) => void (m.t === "notice" && said.push(m.text)), ...more }, () => 10_000);
}

/** Open so many pages; returns their sockets once those are open. */
function pages(count: number): Socket[] {
  for (let i = 0; i < count; i += 1) page();
  pass(50);
  return sockets.splice(0);
}

/** The times at which sockets were opened, in order. */
const times = (): number[] => sockets.map((one) => one.at).sort((a, b) => a - b);

/** The most of these times within so many ms. */
const most = (at: number[], withinMs: number): number =>
  Math.max(...at.map((from) => at.filter((t) => t >= from && t < from + withinMs).length));

let dice = 1;
mock.method(Math, "random", () => (dice = (dice * 48271) % 2147483647) / 2147483647);

beforeEach(() => {
  mock.timers.reset();
  mock.timers.enable({ apis: ["setTimeout", "setInterval"] });
  [now, sockets, reached, answers, dice, listeners] = [0, [], true, true, 1, []];
});

test("the pages of a process that falls silent do not all come back at once", () => {
  const silent = pages(200);
  pass(12_000);
  assert.equal(sockets.length, 200, "each page, once");
  assert.equal(silent.filter((one) => !one.closed).length, 0, "nobody waits for the silent ones any more");
  assert.ok(most(times(), 300) <= 50, `${most(times(), 300)} of 200 within 300 ms`);
});

test("an attempt that is never answered is given up after ten seconds, and another is made", () => {
  answers = false;
  page();
  const closed = (): string => sockets.map((one) => one.closed).join();
  pass(9900);
  assert.equal(closed(), "false");
  pass(200);
  assert.equal(closed(), "true");
  sockets[0]!.end(1006); // as a browser says it
  answers = true;
  pass(3000);
  assert.equal(sockets.length, 2);
  assert.equal(sockets[1]!.closed, false, "one that is open stays");
});

test("a page that is answered before it gave up keeps its socket", () => {
  const live = page();
  pass(50);
  pass(5000);
  assert.ok(live.lost, "it counts as lost already");
  sockets[0]!.say({ t: "pong", n: 1, now_ms: 0 });
  pass(1500);
  assert.ok(!live.lost);
  assert.equal(sockets.length, 1);
});

test("pages whose process was killed come back after random pauses, longer with each failed attempt", () => {
  const killed = pages(100);
  reached = false;
  for (const one of killed) one.end(1006);
  pass(700);
  assert.ok(sockets.length >= 100, "soon");
  assert.ok(most(times(), 100) <= 50, `${most(times(), 100)} of 100 within 100 ms`);
  sockets.length = 0;
  pass(60_000);
  const before = sockets.length;
  pass(24_000);
  const tries = (sockets.length - before) / 100;
  assert.ok(tries > 2 && tries < 4, `${tries} attempts a page in 24 s, one in 8 s`);
  assert.ok(most(times().slice(before), 1000) <= 50, "spread");
});

test("a page that was heard by the new process begins with short pauses again", () => {
  page();
  pass(50);
  reached = false;
  sockets[0]!.end(1006);
  pass(30_000);
  reached = true;
  pass(15_000);
  const last = sockets.at(-1)!;
  last.say({ t: "pong", n: 1, now_ms: 0 });
  last.end(1006);
  pass(700);
  assert.notEqual(sockets.at(-1), last);
});

test("a full robot is tried again after 10 to 30 s and the page says why; one that is gone, never", () => {
  const said: string[] = [];
  page("full", said);
  page("gone");
  pass(50);
  for (const one of sockets.splice(0)) one.end(one.url.includes("full") ? 4503 : 4404);
  pass(60_000);
  assert.ok(sockets[0]!.at > 10_000 && sockets[0]!.at < 30_100, `${sockets[0]!.at}`);
  assert.ok(!sockets.some((one) => one.url.includes("gone")));
  assert.deepEqual(said, ["Too many watch."]);
});

test("whose turn is over gets the public view without a pause", () => {
  page();
  pass(50);
  sockets[0]!.end(4410);
  assert.equal(sockets.length, 2);
});

test("a preview that was asked for without a connection is asked for with the next one, and once", () => {
  const live = page();
  pass(50);
  const first = sockets[0]!;
  first.say({ t: "snapshot", now_ms: 0 });
  reached = false;
  first.readyState = CLOSED;
  first.end(1006);
  assert.equal(live.send({ t: "plan", n: 1 }), false);
  assert.equal(live.send({ t: "plan", n: 2 }), false);
  reached = true;
  pass(15_000);
  const asked = (one: Socket): string[] => one.sent.filter((message) => message.includes('"plan"'));
  assert.deepEqual(asked(sockets.at(-1)!), ['{"t":"plan","n":2}'], "the newest one");
  sockets.at(-1)!.say({ t: "plan", n: 2, ok: true, text: "" });
  sockets.at(-1)!.end(1006);
  pass(15_000);
  assert.deepEqual(asked(sockets.at(-1)!), [], "it has been answered");
});

for (const [name, event] of Object.entries({ pageshow: { persisted: true }, visibilitychange: {}, resume: {} }))
  test(`a socket that died while the page slept is given up soon after ${name}`, () => {
    page();
    pass(50);
    now += 5000; // no timer ran: the device slept
    happens(name, event);
    pass(3500);
    assert.equal(sockets.length, 2);
    assert.equal(sockets[0]!.closed, true);
  });

test("a page that comes back from the browser's cache with a closed socket opens another at once", () => {
  const live = page();
  pass(50);
  sockets[0]!.readyState = CLOSED; // without a word
  happens("pageshow", { persisted: true });
  assert.equal(sockets.length, 2);
  pass(50);
  assert.equal(live.lost, false);
});

test("a page that is seen again does not wait for the pause between two attempts, nor give up a socket that works", () => {
  page();
  pass(50);
  reached = false;
  sockets[0]!.end(1006);
  pass(30_000);
  const before = sockets.length;
  reached = true;
  happens("visibilitychange");
  assert.equal(sockets.length, before + 1);
  pass(50);
  for (let i = 0; i < 5; i++) {
    happens("visibilitychange");
    sockets.at(-1)!.say({ t: "pong", n: i, now_ms: 0 });
    pass(1000);
  }
  assert.equal(sockets.length, before + 1);
});

test("a page that was told that too many watch keeps its pause, also when it is looked at", () => {
  page();
  pass(50);
  sockets[0]!.readyState = CLOSED;
  sockets[0]!.end(4503);
  for (const name of ["visibilitychange", "online"]) happens(name);
  assert.equal(sockets.length, 1);
  pass(31_000);
  assert.ok(sockets.length > 1, "after its pause it tries again");
});

for (const [name, before] of Object.entries({ "before the operator's stream is asked for": true, "while it is opened": false }))
  test(`a motion that is pressed ${name} keeps the socket that carried its command`, async () => {
    let over = false;
    const live = page("rover", [], { busy: () => held.held });
    const held = new HeldMotion({ send: (m) => live.send(m), ended: () => over, refused: () => undefined, late: () => false });
    const press = (): void => {
      live.send({ t: "command", kind: "drive", args: {}, seq: 1 });
      held.hold(1, "drive");
    };
    const asking = mock.method(globalThis, "fetch", () => Promise.resolve({ ok: true, json: () => Promise.resolve({ code: "c" }) }));
    pass(50);
    const first = sockets[0]!;
    first.say({ t: "snapshot", now_ms: 0 });
    if (before) press();
    live.operate();
    await settled();
    pass(50);
    if (!before) press();
    const own = sockets[1]!;
    assert.ok(own.url.includes("/ws/operators/"));
    own.say({ t: "snapshot", now_ms: 0 });
    held.keep(1);
    held.keep(1, { forward: 1 });
    const kept = (one: Socket): number => one.sent.filter((message) => message.includes('"keep"')).length;
    assert.deepEqual([kept(first), kept(own), own.closed], [2, 0, true]);
    if (before) held.release(1);
    else over = true; // the robot has ended it
    pass(10_000);
    live.operate();
    await settled();
    pass(50);
    sockets.at(-1)!.say({ t: "snapshot", now_ms: 0 });
    live.send({ t: "ping", n: 99 });
    assert.match(sockets.at(-1)!.sent.join(), /99/, "from then on the operator's stream is used");
    asking.mock.restore();
  });
