import assert from "node:assert/strict";
import { test } from "node:test";
import { readUnseen, unseenWords } from "../../robots/kit/drivers/srv1/console/unseen.ts";

const bytes = (value: unknown): Uint8Array => new TextEncoder().encode(typeof value === "string" ? value : JSON.stringify(value));
const clock = (ms: number): string => `${ms / 1000} s`;

test("what is no packet is none", () => {
  for (const bad of ["", "{", "null", "[]", "3", "{}", { ways: 1, events: [] }, { ways: [], events: "x" }])
    assert.equal(readUnseen(bytes(bad)), null);
});

test("numbers that are none are left out", () => {
  const packet = '{"ways": [[[1, 2], [null, 2], [3], "x", [3, 4, 5]], 7], "events": [[1, "alone"], ["x", "way"], [1, 2], null]}';
  const told = readUnseen(bytes(packet))!;
  const lengths = told.ways.map((way) => way.length);
  assert.deepEqual(lengths, [2, 0]);
  assert.deepEqual(told.events, [{ ago: 1, event: "alone" }]);
});

test("it says from when to when, how far, and how it ended", () => {
  const events = '[[20000, "alone", 0, 0], [15000, "reflex", 1, 1], [5000, "expired", 3, 4], [4000, "rest", 3, 4]]';
  const told = readUnseen(bytes(`{"ways": [[[0, 0], [3, 4]]], "events": ${events}}`))!;
  assert.deepEqual(unseenWords(told, 100_000, clock), [
    "Out of reach from 80 s to 95 s: it drove 5.0 m by itself, turned away from something near once, and came to rest at the end of its permit.",
  ]);
});

test("each time is a sentence, also one whose end is not told", () => {
  const events = '[[9000, "alone"], [8000, "heard"], [3000, "alone"], [2000, "way"]]';
  const told = readUnseen(bytes(`{"ways": [[[0, 0], [1, 0]], [[1, 0], [2, 0]]], "events": ${events}}`))!;
  const words = unseenWords(told, 10_000, clock);
  assert.equal(words.length, 2);
  assert.match(words[0]!, /from 1 s to 2 s: it drove 1.0 m by itself, and was reached again/);
  assert.match(words[1]!, /from 7 s to 10 s: it drove 1.0 m by itself\.$/);
});
