/** The one clock of a page. */
import assert from "node:assert/strict";
import { mock, test } from "node:test";
import { stub } from "./helpers.ts";

let now = 0; // ms
const reported: unknown[] = [];
stub({ performance: { now: () => now }, reportError: (error: unknown) => void reported.push(error) });
mock.timers.enable({ apis: ["setInterval"] });
const { every } = await import("../src/kit/page_clock.ts");

/** Let time go on; a browser delays the timers of a page that nobody sees, as told by `each`. */
function pass(ms: number, each = 250): void {
  for (let left = ms; left > 0; left -= each) {
    now += each;
    mock.timers.tick(250);
  }
}

test("each is called at its own pace, and all of those that are due together", () => {
  const calls: string[] = [];
  const ends = [every(250, () => calls.push("page")), every(500, () => calls.push("bar")), every(1000, () => calls.push("trace"))];
  pass(1000);
  assert.equal(calls.join(" "), "page page bar page page bar trace");
  ends[1]?.();
  pass(500);
  assert.equal(calls.slice(7).join(" "), "page page");
  for (const end of ends) end();
  pass(1000);
  assert.equal(calls.length, 9);
});

test("a page that nobody sees is drawn as often as the browser lets it", () => {
  let calls = 0;
  const end = every(500, () => (calls += 1));
  pass(5000, 1000);
  assert.equal(calls, 5);
  end();
});

test("one that fails stops none of the others, and is reported", () => {
  let calls = 0;
  const ends = [every(250, () => assert.fail("broken")), every(250, () => (calls += 1))];
  pass(500);
  assert.equal(calls, 2);
  assert.equal(reported.length, 2);
  for (const end of ends) end();
});
