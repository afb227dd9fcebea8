/** The signed-in person's connection: which answer belongs to which request. */
import assert from "node:assert/strict";
import { test, type TestContext } from "node:test";
import type { PersonSocket as Line, QueuePlace } from "../src/queue/person_socket.ts";
import { queuePlace, settled, stub } from "./helpers.ts";

class Socket {
  static CONNECTING = 0;
  static OPEN = 1;
  static last: Socket;
  static begin = Socket.OPEN;
  readyState = Socket.begin;
  closed = 0;
  onclose: ((event: { code: number }) => void) | null = null;
  sent: { what: string; robot: string }[] = [];
  onmessage: ((event: { data: string }) => void) | null = null;
  constructor() {
    Socket.last = this;
  }
  send(text: string): void {
    this.sent.push(JSON.parse(text));
  }
  close(): void {
    this.closed += 1;
    this.onclose?.({ code: 1006 });
  }
  says(message: object): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
}

const listeners: Record<string, () => void> = {};
stub({
  WebSocket: Socket,
  location: { protocol: "http:", host: "localhost" },
  document: { hidden: false, addEventListener: () => undefined },
  addEventListener: (name: string, heard: () => void) => void (listeners[name] = heard),
  fetch: async () => ({ ok: true, type: "basic", json: async () => ({ t: "places", now_ms: Date.now(), places: [], text: "by request" }) }),
});
const { PersonSocket, UNSENT } = await import("../src/queue/person_socket.ts");

const place = (robot: string): QueuePlace => queuePlace({ robot, state: "offered" });
const answer = (to: string, robot: string, text: string): object => ({ t: "answer", to, robot, ok: !text, text });

function connected(t: TestContext): { line: Line; socket: Socket } {
  t.mock.timers.enable({ apis: ["setTimeout", "setInterval"] });
  return { line: new PersonSocket("token", () => undefined), socket: Socket.last };
}

test("an answer within four seconds is the request's", async (t) => {
  const { line, socket } = connected(t);
  const asked = line.ask("accept", place("mercury"));
  assert.equal(socket.sent[0]?.what, "accept");
  socket.says(answer("accept", "mercury", "The offer is over."));
  assert.equal(await asked, "The offer is over.");
});

test("without an answer in four seconds the request is repeated without the socket", async (t) => {
  const { line } = connected(t);
  const asked = line.ask("accept", place("mercury"));
  t.mock.timers.tick(4001);
  assert.equal(await asked, "by request");
});

/** Have requests without the socket fail, as without a connection. */
function unreachable(t: TestContext): void {
  t.mock.method(globalThis, "fetch", async () => Promise.reject(new TypeError("Failed to fetch")));
}

/** Return what was answered by now; undefined: nothing yet. */
async function byNow(asked: Promise<string>): Promise<string | undefined> {
  await settled();
  return Promise.race([asked, Promise.resolve(undefined)]);
}

test("what the socket has taken may arrive later than a request in its place fails, and is not called unsent", async (t) => {
  unreachable(t);
  const { line, socket } = connected(t);
  const accepted = line.ask("accept", place("mercury")),
    dismissed = line.ask("dismiss", place("pa10"));
  t.mock.timers.tick(4001);
  assert.equal(await byNow(accepted), undefined);
  socket.says(answer("accept", "mercury", ""));
  socket.says(answer("dismiss", "pa10", "late, too"));
  assert.deepEqual([await accepted, await dismissed], ["", "late, too"]);
});

test("what a socket had taken that is no more is told as not known", async (t) => {
  unreachable(t);
  const { line, socket } = connected(t);
  const early = line.ask("accept", place("mercury"));
  t.mock.timers.tick(4001);
  assert.equal(await byNow(early), undefined);
  socket.close();
  const late = line.ask("leave", place("mercury")); // there is no socket
  t.mock.timers.tick(1000);
  assert.match(String(await byNow(early)), /whether that was done is not known/);
  assert.equal(await late, UNSENT);
});

test("an answer that comes late is not the next request's", async (t) => {
  const { line, socket } = connected(t);
  const first = line.ask("accept", place("mercury"));
  t.mock.timers.tick(4001);
  await first;
  const next = line.ask("dismiss", place("pa10"));
  socket.says(answer("accept", "mercury", "The offer is over."));
  socket.says(answer("dismiss", "mercury", "of another robot"));
  socket.says(answer("dismiss", "pa10", ""));
  assert.equal(await next, "");
});

test("a request that the server could not read is answered too", async (t) => {
  const { line, socket } = connected(t);
  const asked = line.ask("accept", place("mercury"));
  socket.says(answer("do", "", "That request was not understood."));
  assert.equal(await asked, "That request was not understood.");
});

test("an attempt that is never answered is given up after ten seconds, and another is made", (t) => {
  Socket.begin = Socket.CONNECTING;
  const { socket } = connected(t);
  Socket.begin = Socket.OPEN;
  t.mock.timers.tick(9999);
  assert.equal(socket.closed, 0);
  t.mock.timers.tick(1);
  assert.equal(socket.closed, 1);
  t.mock.timers.tick(2000);
  assert.notEqual(Socket.last, socket);
  t.mock.timers.tick(20_000);
  assert.equal(Socket.last.closed, 0, "one that is open stays");
});

test("a request that nobody answers is given up, and the person is told", async (t) => {
  const limit = new AbortController();
  t.mock.method(AbortSignal, "timeout", () => limit.signal);
  const unanswered = (_: string, { signal }: RequestInit): Promise<never> =>
    new Promise((_, reject) => signal?.addEventListener("abort", () => reject(signal.reason)));
  t.mock.method(globalThis, "fetch", unanswered);
  const { line, socket } = connected(t);
  socket.readyState = 3; // closed
  const asked = line.ask("leave", place("mercury"));
  limit.abort(new DOMException("late", "TimeoutError"));
  assert.match(await Promise.race([asked, new Promise<string>((resolve) => setImmediate(resolve, "waits"))]), /is not known/);
});

test("a socket that does not answer after the device slept is given up within seconds", (t) => {
  let now = 0;
  t.mock.method(performance, "now", () => now);
  const { socket } = connected(t);
  const second = (): void => {
    now += 1000;
    t.mock.timers.tick(1000);
  };
  second();
  listeners["focus"]!();
  for (let i = 0; i < 4; i++) second();
  assert.equal(socket.closed, 0);
  for (let i = 0; i < 3; i++) second();
  assert.equal(socket.closed, 1);
  const next = Socket.last;
  assert.notEqual(next, socket);
  listeners["focus"]!();
  next.says({ t: "places", now_ms: 0, places: [] });
  for (let i = 0; i < 8; i++) second();
  assert.equal(next.closed, 0, "one that answers stays");
});
