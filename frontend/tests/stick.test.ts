import assert from "node:assert/strict";
import { test } from "node:test";
import { byKeys, byPad, byPointer, dampedPush, type Push } from "../src/widgets/stick_rules.ts";
import { gamepad as pad } from "./helpers.ts";

const random =
  (seed: number): (() => number) =>
  () =>
    (seed = (seed * 1103515245 + 12345) % 2 ** 31) / 2 ** 31;

test("a pointer never pushes beyond one, whatever it is", () => {
  const dice = random(7);
  for (let i = 0; i < 2000; i++) {
    const [x, y] = byPointer((dice() - 0.5) * 10 ** (i % 9), (dice() - 0.5) * 10 ** (i % 7), dice() * 100);
    assert.ok(Math.hypot(x, y) <= 1 + 1e-9, `${x} ${y}`);
  }
  for (const bad of [NaN, Infinity]) assert.deepEqual(byPointer(bad, 1, 50), [0, 0]);
  assert.deepEqual(byPointer(1, 1, 0), [0, 0]);
});

test("up is ahead, right is right, and the middle is rest", () => {
  assert.deepEqual(byPointer(0, -100, 50), [0, 1]);
  assert.deepEqual(byPointer(50, 0, 50), [1, 0]);
  assert.deepEqual(byPointer(2, 3, 50), [0, 0]);
  const [x, y] = byPointer(0, -25, 50);
  assert.ok(x === 0 && y > 0.4 && y < 0.5, "by degrees");
});

test("arrow keys push together, and against each other not at all", () => {
  assert.equal(byKeys(new Set(), true), null);
  assert.equal(byKeys(new Set(["a", "toString"]), true), null);
  assert.deepEqual(byKeys(new Set(["ArrowUp", "ArrowLeft"]), true), [-1, 1]);
  assert.deepEqual(byKeys(new Set(["ArrowUp", "ArrowDown"]), true), [0, 0]);
  assert.deepEqual(byKeys(new Set(["ArrowUp"]), false), [0, 0.6]);
});

test("a gamepad pushes by degrees, and its cross as the keys do", () => {
  assert.equal(byPad(null), null);
  assert.equal(byPad(pad([0.1, -0.14])), null);
  assert.equal(byPad(pad([1, 1], [], false)), null);
  assert.deepEqual(byPad(pad([0, -1])), [0, 1]);
  assert.deepEqual(byPad(pad([NaN, -9])), [0, 1]);
  assert.deepEqual(byPad(pad([0, 0], [12])), [0, 0.6]);
  const half = byPad(pad([0.5, 0]))!;
  assert.ok(half[0] > 0.3 && half[0] < 0.5);
});

test("a knob that resists comes later, is never beyond what is wanted, and is drawn back and turned at once", () => {
  const dice = random(3);
  for (let i = 0; i < 2000; i++) {
    const at: Push = [dice() * 2 - 1, dice() * 2 - 1],
      wanted: Push = [dice() * 2 - 1, dice() * 2 - 1],
      force = dice() * 1.4 - 0.2;
    const [x, y] = dampedPush(at, wanted, force, dice());
    assert.equal(x, wanted[0], "it turns at once");
    assert.ok(y <= wanted[1] + 1e-12, "never faster than wanted");
    if (wanted[1] <= 0 || force <= 0) assert.equal(y, wanted[1]);
    else assert.ok(y >= 0, "nothing drives it back");
  }
  const after = (force: number): number => dampedPush([0, 0], [0, 1], force, 0.2)[1];
  assert.equal(after(0), 1);
  assert.equal(after(NaN), 1);
  assert.ok(after(0.2) > after(0.6) && after(0.6) > after(1) && after(1) > 0);
});

test("a knob that is held ahead is pushed back by what comes near, and comes again when that is gone", () => {
  const rests = (from: number, force: number): number => {
    let at: Push = [0, from];
    for (let i = 0; i < 500; i++) at = dampedPush(at, [0, 1], force, 0.04);
    return at[1];
  };
  const resting = [0, 0.2, 0.5, 1].map((force) => rests(1, force));
  const falling = [...resting].sort((a, b) => b - a);
  assert.deepEqual(falling, resting, "the more force, the farther back");
  assert.ok(resting[0] === 1 && resting[3]! > 0.2 && resting[3]! < 0.4);
  for (const [i, force] of [0.2, 0.5, 1].entries()) assert.ok(Math.abs(rests(0, force) - resting[i + 1]!) < 1e-3, "from either side");
  const [, soon] = dampedPush([0, 1], [0, 1], 1, 0.1);
  assert.ok(soon < 1 && soon > 0.7, "by degrees, not in one go");
});
