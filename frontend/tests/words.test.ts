/** Words of times. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { pictureAge, shownLive, watcherWords } from "../src/words.ts";

test("a picture's age is said, and marked from 2 s and 5 s on", () => {
  assert.deepEqual(pictureAge(300, ", 10 a second"), ["Picture 0.3 s old, 10 a second", "fresh"]);
  assert.deepEqual(pictureAge(2100), ["Picture 2.1 s old", "ageing"]);
  assert.deepEqual(pictureAge(65_000), ["Picture 65 s old", "old"]);
});

test("clocks that differ by little make no picture younger than none", () => {
  assert.deepEqual(pictureAge(-400), ["Picture 0.0 s old", "fresh"]);
});

test("a picture from the future has an unknown age, and never looks live", () => {
  assert.deepEqual(pictureAge(-60_000, ", 10 a second"), ["Picture of unknown age", "old"]);
});

test("a picture is live for 5 s, while the server is reached", () => {
  assert.equal(shownLive(1200, false), true);
  assert.equal(shownLive(5001, false), false);
  assert.equal(shownLive(1200, true), false);
  assert.equal(shownLive(-60_000, false), false);
});

test("how many watch is said without the driver, and to each as it is for them", () => {
  assert.deepEqual([0, 1, 2].map((n) => watcherWords(n, true)), ["nobody else watches", "1 other watches", "2 others watch"]);
  assert.deepEqual([0, 1, 2, 3].map((n) => watcherWords(n, false)), ["only you watch", "only you watch", "you and 1 other watch", "you and 2 others watch"]);
});
