/** The ghost of an arm's tool: moves, words, what a hand that takes it does, and pages that stand still. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { Ghost } from "../src/scene/ghost.ts";
import type { Judgement } from "../src/scene/judge.ts";
import {
  distance,
  keyMove,
  type Move,
  moved,
  numbersOfPose,
  placeInWords,
  pointingDown,
  shareOf,
  stepMove,
  STEPS,
  wayInWords,
} from "../src/scene/moves.ts";
import { seededDraw } from "./helpers.ts";
import { isStale } from "../src/input/loop.ts";

const START = Float64Array.of(-1, 0, 0, 0.5, 0, 1, 0, 0.1, 0, 0, -1, 0.3, 0, 0, 0, 1); // points down
const FREE: Judgement = { verdict: "free", text: "", joints: [0], path: [], seconds: 1 };
const table = (pose: ArrayLike<number>): Judgement =>
  pose[11]! >= 0.02 ? FREE : { ...FREE, verdict: "refused", text: "there the fingers would enter the table", joints: null };

const anyMove = (draw: ReturnType<typeof seededDraw>, m = 0.2, rad = 1): Move =>
  Array.from({ length: 6 }, (_, i) => draw(-1, 1) * (i < 3 ? m : rad)) as unknown as Move;

test("a move shifts the tool along the base's axes and turns it about its own point", () => {
  const after = moved(START, [0.01, -0.02, 0.03, 0, 0, Math.PI / 2]);
  assert.deepEqual(
    [after[3], after[7], after[11]].map((v) => v!.toFixed(6)),
    ["0.510000", "0.080000", "0.330000"],
  );
  assert.deepEqual(
    numbersOfPose(after)
      .slice(3)
      .map((v) => Math.round((v * 180) / Math.PI) || 0),
    [180, 0, -90],
  );
});

test("the numbers of a pose give the pose back, also where the tool points along the horizon", () => {
  const draw = seededDraw(7);
  for (let n = 0; n < 500; n++) {
    const pose = moved(START, anyMove(draw, 0.3, n % 5 ? 2 : 0)),
      upright = n % 5 ? pose : moved(START, [0, 0, 0, 0, Math.PI / 2, 0]);
    const [x = 0, y = 0, z = 0, roll = 0, pitch = 0, yaw = 0] = numbersOfPose(upright);
    let back: Float64Array = Float64Array.of(1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1);
    for (const turn of [[roll, 0, 0], [0, pitch, 0], [0, 0, yaw]] as const) back = moved(back, [0, 0, 0, ...turn]); // prettier-ignore
    const far = distance(back, upright);
    assert.ok(far.m < 1e-9 && far.rad < 1e-6, `${n}: ${far.rad}`);
  }
});

test("a way is told in words, and a way of nothing is none", () => {
  assert.equal(wayInWords(START, START), "");
  assert.equal(wayInWords(START, moved(START, [0, 0.012, 0.003, 0, 0, (3 * Math.PI) / 180])), "12 mm left, 3 mm up, 3° about z");
  assert.equal(wayInWords(START, moved(START, [-0.02, -0.001, -0.1, 0, 0, 0])), "20 mm back, 1 mm right, 100 mm down");
});

test("a place in words has whole numbers, no zero with a sign, and half a turn as 180", () => {
  assert.equal(placeInWords(moved(START, [0.0004, -0.1003, 0, 0, 0, 0])), "x, y, z 500, 0, 300 mm; roll, pitch, yaw 180, 0, 180°");
});

test("keys move by a step and turn with Shift; other keys do nothing", () => {
  assert.deepEqual(stepMove(keyMove("ArrowLeft", false)!, STEPS[1]!), [0, 0.005, 0, 0, 0, 0]);
  assert.deepEqual(
    stepMove(keyMove("ArrowLeft", true)!, STEPS[1]!).map((v) => (v * 180) / Math.PI),
    [0, 0, 0, 0, 0, 5],
  );
  assert.equal(keyMove("s", false), null);
  assert.equal(keyMove("toString", false), null);
});

test("there and back by a key is where it was", () => {
  for (const shift of [false, true])
    for (const [one, other] of [
      ["ArrowUp", "ArrowDown"],
      ["ArrowLeft", "ArrowRight"],
      ["PageUp", "PageDown"],
    ] as const) {
      // prettier-ignore
      const there = moved(START, stepMove(keyMove(one, shift)!, STEPS[2]!)),
        back = distance(START, moved(there, stepMove(keyMove(other, shift)!, STEPS[2]!)));
      assert.ok(back.m < 1e-12 && back.rad < 1e-9);
    }
});

test("pointing down keeps the place", () => {
  const down = pointingDown(moved(START, [0.1, 0.2, 0, 1, 0.5, 0]));
  assert.deepEqual(
    numbersOfPose(down)
      .slice(0, 3)
      .map((v) => v.toFixed(6)),
    ["0.600000", "0.300000", "0.300000"],
  );
  assert.ok(distance(pointingDown(START), START).rad < 1e-9);
});

test("a ghost that is taken and let go ten thousand times never leaps", () => {
  const draw = seededDraw(1),
    ghost = new Ghost(() => FREE);
  ghost.follow(START);
  for (let n = 0; n < 10_000; n++) {
    const before = ghost.pose!;
    ghost.take();
    ghost.drag([0, 0, 0, 0, 0, 0]);
    const leap = distance(before, ghost.pose!);
    assert.ok(leap.m < 1e-12 && leap.rad < 1e-7, `${n}`);
    const by = shareOf(anyMove(draw), 1 / (1 + Math.floor(draw(0, 10))));
    ghost.drag(by);
    const went = distance(before, ghost.pose!),
      wanted = Math.hypot(by[0], by[1], by[2]);
    assert.ok(Math.abs(went.m - wanted) < 1e-9, `${n}: a hand's ${wanted} m moved it ${went.m} m`);
    ghost.release();
    ghost.drag(anyMove(draw)); // nobody holds it
    assert.deepEqual(distance(before, ghost.pose!), went);
  }
});

test("a ghost stays where it was when it is refused, says why, and goes on when it may", () => {
  const ghost = new Ghost(table);
  ghost.follow(START);
  ghost.take();
  ghost.drag([0, 0, -0.1, 0, 0, 0]);
  ghost.drag([0, 0, -0.29, 0, 0, 0]);
  assert.equal(ghost.refusal, "there the fingers would enter the table");
  assert.ok(Math.abs(ghost.pose![11]! - 0.2) < 1e-12);
  assert.equal(ghost.judgement?.verdict, "free", "what can be sent is the last place that works");
  ghost.drag([0, 0.05, -0.2, 0, 0, 0]);
  assert.equal(ghost.refusal, "");
  assert.deepEqual(
    [ghost.pose![7], ghost.pose![11]].map((v) => v!.toFixed(6)),
    ["0.150000", "0.100000"],
  );
});

test("a ghost that is dragged against a surface goes on along it, and what the hand wants is refused all the same", () => {
  const along = (_: ArrayLike<number>, to: ArrayLike<number>): Float64Array => {
    const beside = Float64Array.from({ length: 16 }, (_, i) => to[i]!);
    beside[11] = 0.02;
    return beside;
  };
  const ghost = new Ghost(table, undefined, along);
  ghost.follow(START);
  ghost.take();
  ghost.drag([0.05, 0.1, -0.5, 0, 0, 0.2]);
  assert.equal(ghost.refusal, "there the fingers would enter the table");
  assert.deepEqual([3, 7, 11].map((at) => ghost.pose![at]!.toFixed(6)), ["0.550000", "0.200000", "0.020000"]); // prettier-ignore
  ghost.drag([0.05, 0.1, -0.1, 0, 0, 0.2]);
  assert.equal(ghost.refusal, "");
  assert.ok(Math.abs(ghost.pose![11]! - 0.2) < 1e-9, "it does not stick");
});

test("a ghost follows the arm until somebody moves it, and again when it is taken home", () => {
  const ghost = new Ghost(() => FREE),
    other = moved(START, [0.1, 0, 0, 0, 0, 0]);
  assert.equal(ghost.pose, null);
  assert.equal(ghost.step([0, 0, 0.01, 0, 0, 0]), false, "the arm's place is not known");
  ghost.follow(START);
  assert.equal(ghost.away, false);
  ghost.step([0, 0, 0.01, 0, 0, 0]);
  ghost.follow(other);
  assert.ok(Math.abs(ghost.pose![3]! - 0.5) < 1e-12, "it stays where it was put");
  assert.equal(ghost.away, true);
  ghost.take();
  ghost.home();
  ghost.drag([0.5, 0, 0, 0, 0, 0]);
  assert.deepEqual([...ghost.pose!], [...other], "a hand that held it has to take it again");
  assert.equal(ghost.away, false);
});

test("keys that repeat count while the page is awake, not those that waited", () => {
  assert.equal(isStale({ repeat: true, timeStamp: 900 }, 1000), false);
  assert.equal(isStale({ repeat: true, timeStamp: 900 }, 3000), true);
  assert.equal(isStale({ repeat: false, timeStamp: 900 }, 3000), false, "a press that waited is still a press");
});

test("a speed against a surface is not stored up: the ghost comes back at once", () => {
  const ghost = new Ghost(table);
  ghost.follow(START);
  for (let n = 0; n < 500; n++) ghost.nudge([0, 0, -0.005, 0, 0, 0]);
  const low = ghost.pose![11]!;
  assert.ok(low >= 0.02 && low < 0.026);
  assert.equal(ghost.refusal, "there the fingers would enter the table");
  ghost.nudge([0, 0, 0.005, 0, 0, 0]);
  assert.ok(Math.abs(ghost.pose![11]! - low - 0.005) < 1e-9);
  assert.equal(ghost.refusal, "");
});

test("it is told once that the ghost has snapped, and that it left", () => {
  const goal = Float64Array.from(START);
  goal[3] = 0.6;
  const ghost = new Ghost(
    () => FREE,
    (pose) => (distance(pose, goal).m < 0.002 ? goal : pose),
  );
  ghost.follow(START);
  ghost.step([0.05, 0, 0, 0, 0, 0]);
  assert.equal(ghost.snapped, false);
  ghost.step([0.049, 0, 0, 0, 0, 0]);
  assert.equal(ghost.snapped, true);
  ghost.step([0.01, 0, 0, 0, 0, 0]);
  assert.equal(ghost.snapped, false);
});
