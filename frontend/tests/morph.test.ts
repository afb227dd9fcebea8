import assert from "node:assert/strict";
import { test } from "node:test";
import { isToken, align } from "../src/kit/morph.ts";
import { nextPause } from "../src/page/pending_parts.ts";

const kinds = { alike: (a: string, b: string) => a[0] === b[0], weight: (one: string) => (one.includes("!") ? 100 : 1) };
const stays = (old: string[], fresh: string[]): string[] => [...align(old, fresh, kinds)].map(([now, was]) => `${was}>${now}`);

test("what comes between stays apart from what is there", () => {
  assert.deepEqual(
    stays(["h1", "p1", "f1", "u1", "p2"], ["h2", "p3", "p4", "f2", "u2", "p5"]).filter((one) => /^[hfu]/.test(one)),
    ["h1>h2", "f1>f2", "u1>u2"],
  );
  assert.deepEqual(stays(["p1", "f1"], ["f2", "p2"]).length, 1);
  assert.deepEqual(stays([], ["f"]), []);
});

test("what is pressed stays, whatever else has to go for it", () => {
  assert.deepEqual(stays(["p1", "p2", "p3", "f1!"], ["f2", "p4", "p5", "p6"]), ["f1!>f2"]);
});

test("tokens of forms are no news, what somebody chose is", () => {
  for (const name of ["csrfmiddlewaretoken", "once", "press"]) assert.ok(isToken("hidden", name));
  assert.ok(!isToken("hidden", "kind"));
  assert.ok(!isToken("text", "once"));
});

test("without news the pause grows to ten seconds", () => {
  let pause = nextPause(5000, true);
  assert.equal(pause, 1000);
  for (let n = 0; n < 9; n++) pause = nextPause(pause, false);
  assert.equal(pause, 10_000);
});
