/** Words of times. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { pictureAge, isLive } from "../src/media/pictures.ts";
import { joinWait, queueSentence, waitSentence, waitWords, watcherWords } from "../src/queue/waits.ts";
import { vectorsOf } from "./helpers.ts";

test("a picture's age is said, and marked from 2 s and 5 s on", () => {
  assert.deepEqual(pictureAge(300, "10"), ["Picture 0.3 s old, 10 a second", "fresh"]);
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
  assert.equal(isLive(1200, false), true);
  assert.equal(isLive(5001, false), false);
  assert.equal(isLive(1200, true), false);
  assert.equal(isLive(-60_000, false), false);
});

test("how many watch is said without the driver, and to each as it is for them", () => {
  const toDriver = [0, 1, 2].map((n) => watcherWords(n, true)),
    toOther = [0, 1, 2, 3].map((n) => watcherWords(n, false));
  assert.deepEqual(toDriver, ["nobody else watches", "1 other watches", "2 others watch"]);
  assert.deepEqual(toOther, ["only you watch", "only you watch", "you and 1 other watch", "you and 2 others watch"]);
});

const WAITS = vectorsOf<{ wait: [number, number] | null; said: string }[]>("waits");

test("a wait is said as the server's own pages say it", () => {
  assert.ok(WAITS.length > 10);
  for (const { wait, said } of WAITS) assert.equal(waitSentence(wait), said);
});

test("no wait is said with a zero, a fraction, a range of one or more precisely than it is known", () => {
  for (let high = 0; high < 20_000; high += high < 200 ? 1 : 97)
    for (const low of [0, high >> 3, high >> 1, high]) {
      const words = waitWords([low, high]);
      assert.doesNotMatch(words, /\b0\b|\.|NaN|undefined/, words);
      const [, near, far] = /^about (\d+ (?:min|h)) to (\d+ (?:min|h))$/.exec(words) ?? [];
      assert.ok(!near || near !== far, words);
    }
});

test("the wait of somebody who joins is said as the server says it", () => {
  const joins = vectorsOf<{ state: string; free: boolean; wait: [number, number] | null; said: string }[]>("joins");
  for (const { state, free, wait, said } of joins) assert.equal(joinWait(state, free, wait), said);
});

test("nobody, one and several wait", () => {
  assert.deepEqual([0, 1, 2].map(queueSentence), ["Nobody waits.", "1 in the queue.", "2 in the queue."]);
});
