/** The service worker's answers to a click on a notification and to a new address of the browser. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { stub } from "./helpers.ts";

type Listener = (event: object) => void;
const listeners = new Map<string, Listener>();
const focused: string[] = [];
const opened: string[] = [];
let windows: string[] = [];
let sent: { method: string; body: string }[] = [];
let state = { key: "KEY", token: "TOKEN", told: true };
let subscribed: object[] = [];
const fresh = { endpoint: "https://push.example.org/new", toJSON: () => ({ keys: { p256dh: "P", auth: "A" } }) };

stub({
  self: {
    addEventListener: (name: string, listener: Listener) => listeners.set(name, listener),
    clients: {
      matchAll: () => Promise.resolve(windows.map((url) => ({ url, focus: () => Promise.resolve(focused.push(url)) }))),
      openWindow: (url: string) => Promise.resolve(opened.push(url)),
    },
    registration: {
      pushManager: {
        subscribe: (options: object) => {
          subscribed.push(options);
          return Promise.resolve(fresh);
        },
      },
    },
  },
  fetch: (address: string, { method = "GET", body = "" }: { method?: string; body?: object | string }) => {
    assert.equal(address, "/me/push/");
    sent.push({ method, body: String(body) });
    return Promise.resolve({ ok: true, json: () => Promise.resolve(state) });
  },
});
await import("../src/push/worker.ts");

beforeEach(() => {
  [windows, sent, subscribed] = [[], [], []];
  focused.length = opened.length = 0;
  state = { key: "KEY", token: "TOKEN", told: true };
});

async function happen(name: string, event: object): Promise<void> {
  let work: Promise<unknown> = Promise.resolve();
  listeners.get(name)?.({ ...event, waitUntil: (given: Promise<unknown>) => (work = given) });
  await work;
}

async function click(): Promise<boolean> {
  let closed = false;
  await happen("notificationclick", { notification: { data: { url: "/robots/mercury/" }, close: () => (closed = true) } });
  return closed;
}

test("a click focuses the robot's page where it is open, and opens it where it is not", async () => {
  windows = ["https://robots.example.org/log/", "https://robots.example.org/robots/mercury/?a=1"];
  assert.equal(await click(), true);
  assert.deepEqual([focused, opened], [[windows[1]], []]);
  windows = ["https://robots.example.org/robots/mercury/programs/"];
  await click();
  assert.deepEqual([focused.length, opened], [1, ["/robots/mercury/"]]);
});

test("a new address of the browser is told to the portal, with its token", async () => {
  await happen("pushsubscriptionchange", {});
  assert.deepEqual(subscribed, [{ userVisibleOnly: true, applicationServerKey: "KEY" }]);
  assert.deepEqual(
    sent.map((one) => one.method),
    ["GET", "POST"],
  );
  assert.deepEqual(Object.fromEntries(new URLSearchParams(sent[1]!.body)), {
    do: "renew",
    csrfmiddlewaretoken: "TOKEN",
    endpoint: fresh.endpoint,
    p256dh: "P",
    auth: "A",
  });
});

test("a browser that the portal does not tell any more asks no push service", async () => {
  state = { ...state, told: false };
  await happen("pushsubscriptionchange", {});
  assert.deepEqual([subscribed, sent.length], [[], 1]);
});

test("the worker answers no request of a page", () => {
  assert.deepEqual([...listeners.keys()].sort(), ["install", "notificationclick", "push", "pushsubscriptionchange"]);
});
