/** The ghost of a tool: clutch, jumps, frozen views, snapping, surfaces. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { Clutch, FROZEN_S, JUMP_M } from "../src/motion/clutch.ts";
import type { ArmFacts } from "../src/motion/facts.ts";
import { allowedBy, Ghost, ghostOf, missingTo } from "../src/motion/ghost.ts";
import { Planner } from "../src/motion/planner.ts";
import { between, poseOf, type Quaternion, type Rigid, rigidOf, turnedBy } from "../src/motion/rigid.ts";
import { slide } from "../src/motion/slide.ts";
import { norm, plus, type Vec3 } from "../src/motion/vectors.ts";
import { seededDraw, vectorsOf } from "./helpers.ts";

const UPRIGHT: Quaternion = [0, 0, 0, 1];
const HOME: Rigid = { at: [0.5, 0, 0.3], turn: UPRIGHT };
const SHOULDER: Vec3 = [0, 0, 0.3];
const STEP_S = 1 / 60;
const everywhere = (): boolean => true;

function anyVector(draw: ReturnType<typeof seededDraw>, size: number): Vec3 {
  return [draw(-size, size), draw(-size, size), draw(-size, size)];
}
const anyPose = (draw: ReturnType<typeof seededDraw>): Rigid => ({ at: anyVector(draw, 1), turn: turnedBy(UPRIGHT, anyVector(draw, 2)) });
const distance = (a: Rigid, b: Rigid): number => norm(between(a, b).way);
const shifted = (pose: Rigid, way: Vec3): Rigid => ({ at: plus(pose.at, way), turn: pose.turn });

/** Lead the ghost with the hand by steps of a frame, then hold still until the filter has followed. */
function lead(ghost: Ghost, hand: Rigid, way: Vec3, steps: number, from_s = 0): Rigid {
  let here = hand,
    now = from_s;
  for (let n = 0; n < steps + 40; n++) {
    if (n < steps) here = shifted(here, [way[0] / steps, way[1] / steps, way[2] / steps]);
    assert.ok(ghost.move(here, (now += STEP_S)));
  }
  return here;
}

test("ten thousand engagements make no jump, wherever the hand is", () => {
  const draw = seededDraw(4),
    ghost = new Ghost(HOME, everywhere, SHOULDER);
  let now = 0;
  for (let n = 0; n < 10_000; n++) {
    const hand = anyPose(draw),
      before = ghost.pose;
    assert.ok(ghost.engage(hand, (now += draw(0, 3)), draw(1, 10)));
    assert.ok(ghost.move(hand, (now += draw(0, 0.2))));
    const { way, turn } = between(before, ghost.pose);
    assert.ok(norm(way) < 1e-12 && norm(turn) < 1e-12, `${n}: ${norm(way)} m, ${norm(turn)} rad`);
    if (n % 3) ghost.release();
  }
  const { way, turn } = between(HOME, ghost.pose);
  assert.ok(norm(way) < 1e-9 && norm(turn) < 1e-6);
});

test("the ghost moves as the hand does, or so many times less", () => {
  const draw = seededDraw(5);
  for (let n = 0; n < 40; n++) {
    const scale = draw(1, 10),
      way = anyVector(draw, 0.2),
      hand = anyPose(draw),
      ghost = new Ghost(HOME, everywhere, SHOULDER);
    ghost.engage(hand, 0, scale);
    lead(ghost, hand, way, 30);
    const wanted = shifted(HOME, [way[0] / scale, way[1] / scale, way[2] / scale]);
    assert.ok(distance(ghost.pose, wanted) < 1e-6, `1:${scale}: ${distance(ghost.pose, wanted)} m off`);
  }
  const clutch = new Clutch();
  for (const [asked, used] of [
    [0.1, 1],
    [NaN, 1],
    [99, 10],
  ] as const) {
    clutch.engage(HOME, 0, asked);
    const moved = clutch.move(shifted(HOME, [0.01, 0, 0]), 10 * STEP_S)!.way[0];
    clutch.engage(HOME, 0, used);
    assert.equal(moved, clutch.move(shifted(HOME, [0.01, 0, 0]), 10 * STEP_S)!.way[0]);
  }
});

test("a hand that jumps, or is nowhere, loses the ghost, which stays where it is", () => {
  const draw = seededDraw(6);
  for (let n = 0; n < 200; n++) {
    const ghost = new Ghost(HOME, everywhere, SHOULDER),
      hand = anyPose(draw),
      way = anyVector(draw, 1);
    ghost.engage(hand, 0);
    const jump = JUMP_M * (1.001 + draw(0, 5)),
      far = norm(way),
      there = shifted(hand, [(way[0] * jump) / far, (way[1] * jump) / far, (way[2] * jump) / far]);
    const gone = n % 4 ? there : { at: [NaN, 0, 0] as Vec3, turn: UPRIGHT };
    assert.equal(ghost.move(gone, STEP_S), false);
    assert.equal(ghost.clutch.engaged, false);
    assert.equal(ghost.move(there, 2 * STEP_S), false);
    assert.equal(distance(ghost.pose, HOME), 0);
    assert.equal(ghost.engage({ at: hand.at, turn: [NaN, 0, 0, 1] }, 0), false);
  }
});

test("a view that froze does not lurch when it comes back: what the hand did meanwhile is not done", () => {
  const draw = seededDraw(7);
  for (let n = 0; n < 200; n++) {
    const ghost = new Ghost(HOME, everywhere, SHOULDER),
      hand = anyPose(draw),
      pause = draw(FROZEN_S + 0.01, 60);
    ghost.engage(hand, 0);
    let here = lead(ghost, hand, [0.03, 0, 0], 5);
    const before = ghost.pose;
    let now = 45 * STEP_S + pause;
    here = shifted(here, [0, 0.09, 0]);
    assert.ok(ghost.move(here, now));
    assert.equal(distance(ghost.pose, before), 0);
    for (let k = 0; k < 30; k++) assert.ok(ghost.move(here, (now += STEP_S)));
    assert.ok(distance(ghost.pose, before) < 1e-12);
    here = shifted(here, [0, 0, 0.004]);
    ghost.move(here, now + STEP_S);
    assert.ok(distance(ghost.pose, before) <= 0.004 + 1e-12);
  }
});

test("near its goal the ghost snaps, and what is missing is told in words", () => {
  const turned = (degrees: number): Quaternion => turnedBy(UPRIGHT, [0, 0, (degrees * Math.PI) / 180]);
  const at = (mm: number, degrees: number): Rigid => ({ at: [0.5 + mm / 1000, 0, 0.3], turn: turned(degrees) });
  for (const [mm, degrees, words, snaps] of [
    [12, 3, "12 mm left, 3 degrees", false],
    [1.99, 1.99, "2 mm left, 2 degrees", true],
    [2.1, 0, "2 mm left, 0 degrees", false],
    [0, 2.1, "0 mm left, 2 degrees", false],
    [0, 1, "0 mm left, 1 degree", true],
    [0, 170, "0 mm left, 170 degrees", false],
  ] as const) {
    const ghost = new Ghost(at(mm, degrees), everywhere, SHOULDER);
    ghost.aim(HOME);
    assert.deepEqual([missingTo(HOME, at(mm, degrees)).words, missingTo(HOME, at(mm, degrees)).snaps], [words, snaps]);
    assert.equal(ghost.pose === HOME, snaps, words);
    assert.equal(ghost.missing?.m === 0, snaps || mm === 0);
  }
  const refused = new Ghost(at(1, 0), ({ at: [x] }) => x > 0.5005, SHOULDER);
  refused.aim(HOME);
  assert.notEqual(refused.pose, HOME); // the tool may not be there
  const free = new Ghost(at(1, 0), everywhere, SHOULDER);
  free.aim(HOME);
  free.engage(at(0, 0), 0);
  lead(free, at(0, 0), [0.004, 0, 0], 4);
  assert.ok(Math.abs(distance(free.pose, HOME) - 0.004) < 1e-6); // out of its goal again, by as much as the hand moved
});

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

test("the museum arm's ghost is pushed onto the table: it stays above it, slides, and the arm can stand there", () => {
  const { arms } = vectorsOf<{ arms: Record<string, { facts: ArmFacts; ready: number[] }> }>("arm_motions"),
    { facts, ready } = arms["pa10"]!,
    planner = new Planner(facts),
    ghost = ghostOf(planner, ready),
    hand = rigidOf(poseOf(HOME)),
    start = ghost.pose;
  ghost.engage(hand, 0);
  lead(ghost, hand, [0.0, 0.15, -0.6], 60);
  assert.ok(ghost.stopped);
  const joints = planner.reach(poseOf(ghost.pose), ready),
    touch = planner.zones.nearest(joints)!;
  assert.equal(touch.box, "the table");
  assert.ok(touch.distance > 0.0009 && touch.distance < 0.004, `${touch.distance}`);
  assert.ok(ghost.pose.at[1] - start.at[1] > 0.12, `${ghost.pose.at[1] - start.at[1]}`);
  assert.ok(allowedBy(planner, ready)(ghost.pose));
});
