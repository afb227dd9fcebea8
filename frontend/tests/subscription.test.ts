/** What a page asks of the next socket after one that has failed. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { Subscription } from "../src/media/subscription.ts";
import { stub } from "./helpers.ts";

let now = 0; // ms
stub({ performance: { now: () => now } });
const line = { send: () => true, now: () => now, check: () => undefined, latency: 20, best: 20, overdue: false, lost: false };

function page(): Subscription {
  const made = new Subscription(() => line, "vp8", false);
  made.wish();
  made.opened();
  made.judgeLine(true);
  made.arrived({ camera: 0, atMs: now, number: 1 }, 6000);
  return made;
}

beforeEach(() => (now = 0));

test("an outage is no slow line: attempts that never open change nothing", () => {
  const made = page();
  for (let i = 0; i < 8; i += 1) {
    now += 2000;
    made.wish();
  }
  made.opened();
  assert.equal(made.pace, "live");
});

test("sockets through which no picture comes lead to less and less", () => {
  const made = page();
  for (let i = 0; i < 4; i += 1) {
    now += 4000;
    made.wish();
    made.opened();
  }
  assert.notEqual(made.pace, "live");
});

test("only a line that brings everything in time may carry more", () => {
  assert.equal(page().good, true);
  const saving = new Subscription(() => line, "vp8", true);
  assert.equal(saving.good, false, "the browser asks to save data");
  for (const bad of [{ lost: true }, { overdue: true }, { latency: 3000 }]) {
    const made = new Subscription(() => ({ ...line, ...bad }), "vp8", false);
    assert.equal(made.good, false, JSON.stringify(bad));
  }
  const made = page();
  for (let number = 10; number < 60; number += 10) {
    now += 500;
    made.arrived({ camera: 0, atMs: now, number }, 6000);
  }
  assert.equal(made.good, false, "nine of ten pictures are missing");
});
