/** The screen stays on for as long as somebody drives. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { stub } from "./helpers.ts";

let locks: { released: boolean; release(): Promise<void> }[] = [];
let seen: () => void = () => undefined;
let allowed = true;
const wakeLock = {
  request: async (): Promise<object> => {
    if (!allowed) throw new DOMException("low battery", "NotAllowedError");
    const lock = { released: false, release: async () => void (lock.released = true) };
    locks.push(lock);
    return lock;
  },
};
stub({ document: { hidden: false, addEventListener: (_: string, heard: () => void) => (seen = heard) }, navigator: { wakeLock } });
const { ScreenWakeLock } = await import("../src/kit/wake_lock.ts");
const done = (): Promise<void> => new Promise((resolve) => setImmediate(resolve));
const held = (): number => locks.filter((lock) => !lock.released).length;

beforeEach(() => {
  [locks, allowed] = [[], true];
  Object.assign(document, { hidden: false });
  stub({ navigator: { wakeLock } });
});

test("one lock is held during a turn, and none after it", async () => {
  const awake = new ScreenWakeLock();
  for (let i = 0; i < 3; i++) awake.keep(true); // at each drawing
  await done();
  assert.equal(locks.length, 1);
  awake.keep(false);
  await done();
  assert.equal(held(), 0);
});

test("a lock that the browser ended with the page hidden is asked for again when it is seen", async () => {
  const awake = new ScreenWakeLock();
  awake.keep(true);
  await done();
  Object.assign(document, { hidden: true });
  await locks[0]!.release();
  seen();
  await done();
  assert.equal(locks.length, 1, "not while it is hidden");
  Object.assign(document, { hidden: false });
  seen();
  await done();
  assert.equal(held(), 1);
});

test("a turn that ends while the browser still thinks leaves no lock", async () => {
  const awake = new ScreenWakeLock();
  awake.keep(true);
  awake.keep(false);
  await done();
  assert.equal(held(), 0);
});

test("a browser that refuses, or has no locks, changes nothing; a refusal is not for ever", async () => {
  allowed = false;
  const awake = new ScreenWakeLock();
  awake.keep(true);
  await done();
  allowed = true;
  seen();
  await done();
  assert.equal(held(), 1);
  stub({ navigator: {} });
  new ScreenWakeLock().keep(true);
  await done();
  assert.equal(locks.length, 1);
});
