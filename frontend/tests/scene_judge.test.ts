/** What a scene's page says of places for an arm's tool, with the arms that ship. */
import assert from "node:assert/strict";
import { test } from "node:test";
import type { ArmFacts } from "../src/motion/facts.ts";
import { Ghost } from "../src/scene/ghost.ts";
import { PoseJudge } from "../src/scene/judge.ts";
import { distance, moved } from "../src/scene/moves.ts";
import { seededDraw, vectorsOf } from "./helpers.ts";

const { arms } = vectorsOf<{ arms: Record<string, { facts: ArmFacts; ready: number[] }> }>("arm_motions");

for (const name of ["pa10", "puma"]) {
  const { facts, ready } = arms[name]!,
    judge = new PoseJudge(facts, []),
    at = moved(judge.tool(ready), [-0.15, 0, 0, 0, 0, 0]), // where the arm reaches down to the table
    wish = { straight: false, share: 0.5 };

  test(`${name}: beside the arm is free, in the table and out of reach are refused in the server's words`, () => {
    const beside = judge.judge({ ...wish, pose: moved(at, [0, 0.03, -0.02, 0, 0, 0.1]) }, ready);
    assert.equal(beside.verdict, "free", beside.text);
    assert.ok(beside.seconds > 0.1 && beside.seconds < 5);
    const [first, last] = [beside.path[0]!, beside.path.at(-1)!];
    assert.ok(Math.abs(first[1]! - judge.tool(ready)[7]!) < 1e-9 && Math.abs(last[1]! - at[7]! - 0.03) < 1e-6, "the path leads there");
    const below = judge.judge({ ...wish, pose: moved(at, [0, 0, -at[11]! - 0.05, 0, 0, 0]) }, ready);
    assert.equal(below.verdict, "refused");
    assert.match(below.text, /would enter the table$/);
    assert.equal(judge.judge({ ...wish, pose: moved(at, [2, 0, 0, 0, 0, 0]) }, ready).verdict, "refused");
    const straight = judge.judge({ ...wish, straight: true, pose: moved(at, [0, 0.03, 0, 0, 0, 0]) }, ready);
    assert.deepEqual([straight.verdict, straight.seconds, straight.path.length], ["free", NaN, 2]);
  });

  test(`${name}: a box of staff is a box`, () => {
    const there = moved(at, [0, 0.1, 0, 0, 0, 0]),
      [x = 0, y = 0, z = 0] = [there[3], there[7], there[11]],
      vase = { name: "the vase", low: [x - 0.02, y - 0.02, z - 0.02], high: [x + 0.02, y + 0.02, z + 0.02] };
    assert.equal(judge.judge({ ...wish, pose: there }, ready).verdict, "free");
    const refused = new PoseJudge(facts, [vase]).judge({ ...wish, pose: there }, ready);
    assert.equal(refused.verdict, "refused");
    assert.match(refused.text, /would enter the vase$/);
  });

  test(`${name}: a ghost that is pushed into the table stops at it, slides along, and is never where the arm cannot be`, () => {
    const ghost = new Ghost(
      (pose) => judge.judge({ ...wish, pose }, ready),
      undefined,
      (from, to) => judge.along(from, to, ready),
    );
    ghost.follow(at);
    ghost.take();
    const down = -at[11]! - 0.05;
    for (let n = 1; n <= 10; n++) ghost.drag([0, 0.01 * n, (down * n) / 10, 0, 0, 0]);
    for (let n = 0; n < 3; n++) ghost.drag([0, 0.1, down, 0, 0, 0]);
    assert.match(ghost.refusal, /would enter the table$/);
    assert.ok(Math.abs(ghost.pose![7]! - at[7]! - 0.1) < 0.002, "along the table it goes with the hand");
    assert.ok(ghost.pose![11]! < 0.06, `down to the table: ${ghost.pose![11]}`);
    const draw = seededDraw(11);
    for (let n = 0; n < 60; n++) {
      if (n % 6 === 0) ghost.take();
      ghost.drag([draw(-0.3, 0.3), draw(-0.3, 0.3), draw(-0.5, 0.1), draw(-0.5, 0.5), draw(-0.5, 0.5), draw(-0.5, 0.5)]);
      const verdict = judge.judge({ ...wish, pose: ghost.pose! }, ready);
      assert.notEqual(verdict.verdict, "refused", verdict.text);
    }
    ghost.home();
    assert.ok(distance(ghost.pose!, at).m < 1e-12);
  });
}
