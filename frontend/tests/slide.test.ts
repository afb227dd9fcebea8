/** What stops at surfaces slides along them. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { between, type Quaternion, type Rigid, turnedBy } from "../src/motion/rigid.ts";
import { slide } from "../src/motion/slide.ts";
import { norm, plus, type Vec3 } from "../src/motion/vectors.ts";
import { seededDraw } from "./helpers.ts";

const UPRIGHT: Quaternion = [0, 0, 0, 1];
const HOME: Rigid = { at: [0.5, 0, 0.3], turn: UPRIGHT };
const SHOULDER: Vec3 = [0, 0, 0.3];

function anyVector(draw: ReturnType<typeof seededDraw>, size: number): Vec3 {
  return [draw(-size, size), draw(-size, size), draw(-size, size)];
}
const distance = (a: Rigid, b: Rigid): number => norm(between(a, b).way);

test("a ghost never enters what is forbidden, and slides along it", () => {
  const draw = seededDraw(8);
  const above = ({ at: [, , z] }: Rigid): boolean => z >= 0.1,
    reached = ({ at: [x, y, z] }: Rigid): boolean => Math.hypot(x, y, z - 0.3) <= 0.7;
  for (const allowed of [above, reached])
    for (let n = 0; n < 60; n++) {
      let pose = HOME;
      for (let k = 0; k < 30; k++) {
        const wish = { at: plus(pose.at, anyVector(draw, 0.08)), turn: turnedBy(pose.turn, anyVector(draw, 0.2)) };
        pose = slide(pose, wish, allowed, SHOULDER).pose;
        assert.ok(allowed(pose));
      }
    }
  const pushed = slide({ at: [0.5, 0, 0.11], turn: UPRIGHT }, { at: [0.56, 0.03, 0.06], turn: UPRIGHT }, above, SHOULDER);
  assert.ok(pushed.stopped && distance(pushed.pose, { at: [0.56, 0.03, 0.1], turn: UPRIGHT }) < 1e-3);
  const out = slide({ at: [0.69, 0, 0.3], turn: UPRIGHT }, { at: [0.73, 0.06, 0.3], turn: UPRIGHT }, reached, SHOULDER);
  assert.ok(out.stopped && out.pose.at[1] > 0.04 && Math.hypot(out.pose.at[0], out.pose.at[1]) > 0.69);
});
