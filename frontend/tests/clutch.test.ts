/** The clutch between a hand and the ghost: engagements, jumps, the filter, a view that froze. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { Clutch, FROZEN_S, isJump, JUMP_M, JUMP_RAD } from "../src/input/clutch.ts";
import { HOME, type Move, placeOf } from "../src/input/source.ts";
import { type Change, moved, type Rigid } from "../src/motion/rigid.ts";
import { norm } from "../src/motion/vectors.ts";
import { seededDraw } from "./helpers.ts";

const STEP_S = 0.04;
const anywhere = (draw: ReturnType<typeof seededDraw>): Rigid => placeOf(Array.from({ length: 6 }, () => draw(-2, 2)) as unknown as Move);
const nothing = ({ way, turn }: Change): boolean => norm(way) < 1e-12 && norm(turn) < 1e-7;

test("a hand that engages ten thousand times, wherever it is, makes no jump", () => {
  const draw = seededDraw(3),
    clutch = new Clutch();
  for (let n = 0; n < 10_000; n++) {
    const hand = anywhere(draw);
    assert.equal(clutch.engage(hand), true);
    assert.ok(nothing(clutch.move(hand, draw(0, 2))!), `${n}: engaged, and it has not moved`);
    const by: Change = { way: [draw(-0.05, 0.05), draw(-0.05, 0.05), draw(-0.05, 0.05)], turn: [draw(-0.4, 0.4), 0, 0] },
      went = clutch.move(moved(hand, by), STEP_S)!;
    assert.ok(norm(went.way) <= norm(by.way) + 1e-12 && norm(went.turn) <= norm(by.turn) + 1e-9, `${n}: never more than the hand`);
    if (n % 2) clutch.release();
  }
});

test("the filter comes to where the hand is, and starts anew with each engagement", () => {
  const clutch = new Clutch({ smooth_s: 0.06 }),
    there = placeOf([0.05, 0, 0, 0, 0, 0.3]);
  clutch.engage(HOME);
  let at = moved(HOME, clutch.move(there, STEP_S)!);
  assert.ok(at.at[0] > 0.01 && at.at[0] < 0.05, "smoothed");
  for (let n = 0; n < 40; n++) at = moved(at, clutch.move(there, STEP_S)!);
  assert.ok(Math.abs(at.at[0] - 0.05) < 1e-6);
  clutch.engage(HOME);
  clutch.move(there, STEP_S); // the rest of this way is still in the filter
  clutch.release();
  clutch.engage(there);
  assert.ok(nothing(clutch.move(there, STEP_S)!), "nothing is left of the engagement before");
});

test("a hand that jumps 0.1 m is lost until it engages again", () => {
  for (const [by, isLost] of [
    [[JUMP_M * 0.99, 0, 0, 0, 0, 0], false],
    [[JUMP_M * 1.01, 0, 0, 0, 0, 0], true],
    [[0, 0, 0, 0, JUMP_RAD * 1.01, 0], true],
  ] as [Move, boolean][]) {
    const clutch = new Clutch();
    clutch.engage(HOME);
    assert.equal(clutch.move(placeOf(by), STEP_S) === null, isLost);
    assert.equal(clutch.engaged, !isLost);
    if (isLost) assert.equal(clutch.move(HOME, STEP_S), null, "also if it comes back");
  }
  assert.equal(isJump({ way: [NaN, 0, 0], turn: [0, 0, 0] }), true);
});

test("what a hand did while the view froze is not done", () => {
  const clutch = new Clutch({ mayJump: true });
  clutch.engage(HOME);
  const there = placeOf([0.09, 0, 0, 0, 0, 0.5]);
  assert.ok(nothing(clutch.move(there, FROZEN_S * 1.1)!));
  assert.ok(nothing(clutch.move(there, STEP_S)!), "nor afterwards");
  const went = clutch.move(moved(there, { way: [0.01, 0, 0], turn: [0, 0, 0] }), STEP_S)!;
  assert.ok(norm(went.way) > 0 && norm(went.way) <= 0.01);
});

test("what is no place of a hand engages nothing and moves nothing", () => {
  const bad: Rigid[] = [
    { at: [NaN, 0, 0], turn: [0, 0, 0, 1] },
    { at: [0, Infinity, 0], turn: [0, 0, 0, 1] },
    { at: [0, 0, 0], turn: [0, 0, 0, 0] },
    { at: [0, 0, 0], turn: [0, 0, 0, 2] },
  ];
  for (const hand of bad) {
    const clutch = new Clutch({ mayJump: true });
    assert.equal(clutch.engage(hand), false);
    clutch.engage(HOME);
    assert.equal(clutch.move(hand, STEP_S), null);
    assert.equal(clutch.engaged, false);
  }
});
