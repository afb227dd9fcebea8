/** Paths are read as Python packs them; a motion is expected until a state says more, and never counts as measured. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { Prediction } from "../src/arm/prediction.ts";
import { decode } from "../src/socket/decoder.ts";
import { jointsAt } from "../src/socket/joint_path.ts";
import type { CompactLayout, PathPacket, StatePacket } from "../src/socket/packets.ts";
import { bytesOf, vectorsOf } from "./helpers.ts";

interface Packed {
  what: string;
  layout: CompactLayout;
  began_ms: number;
  hex: string;
  read: { command: number; knots: number[][]; seconds: number; velocity: number[] };
  at: [t: number, joints: number[]][];
}

const near = (found: readonly number[], wanted: readonly number[], within: number, what: string): void => {
  assert.equal(found.length, wanted.length, what);
  wanted.forEach((value, i) => assert.ok(Math.abs(found[i]! - value) < within, `${what}: ${found} is not ${wanted}`));
};

test("paths are read as Python packs them, say where the joints are, and nothing else is read", () => {
  for (const { what, layout, began_ms, hex, read, at } of vectorsOf<Packed[]>("path_packets")) {
    const bytes = bytesOf(hex);
    for (const late of [-3_600_000, 0, 3_600_000]) {
      const found = decode(bytes.buffer, layout, began_ms + late) as PathPacket;
      assert.deepEqual([found.command, found.beganMs, found.seconds], [read.command, began_ms, read.seconds], what);
      found.knots.forEach((knot, k) => near(knot, read.knots[k]!, 1e-9, what));
      near(found.velocity, read.velocity, 1e-9, what);
      for (const [t, joints] of at) near(jointsAt(found, t), joints, 1e-9, what);
    }
    for (let length = 0; length < bytes.length; length++) assert.equal(decode(bytes.slice(0, length).buffer, layout, 0), null, what);
    assert.equal(decode(new Uint8Array([...bytes, ...new Uint8Array(40)]).buffer, layout, 0), null, `${what}, too long`);
    assert.equal(decode(bytes.buffer, { ...layout, mark: layout.mark ^ 1 }, 0), null, `${what}, of another layout`);
    assert.equal(decode(bytes.buffer, null, 0), null, `${what}, of a robot without a layout`);
  }
});

const BEGAN = 1_000_000;
const PATH: PathPacket = {
  command: 7,
  beganMs: BEGAN,
  seconds: 4,
  knots: [
    [0, 0],
    [1, 0.5],
  ],
  velocity: [],
};
const ARM_M = 0.5; // the tool of an arm of two joints, whose second does not move it

function told(joints: number[], atMs: number, more: Partial<StatePacket> = {}): StatePacket {
  return { moving: true, stopped: false, number: 0, atMs, joints, velocities: [], torques: [], values: [], mode: "", ...more };
}

/** Return a prediction of `PATH` with a clock that can be set. */
function begun(): { clock: { ms: number }; expected: Prediction } {
  const clock = { ms: BEGAN };
  const expected = new Prediction(
    () => clock.ms,
    ([q = 0]) => [ARM_M * Math.cos(q), ARM_M * Math.sin(q), 0],
  );
  expected.begin(PATH);
  return { clock, expected };
}

test("the motion is expected from its path before any state has come", () => {
  const { clock, expected } = begun();
  for (const ms of [0, 500, 2000, 4000, 60_000]) {
    clock.ms = BEGAN + ms;
    assert.deepEqual(expected.joints, { predicted: jointsAt(PATH, ms / 1000) });
  }
});

test("states that come late confirm the motion, and the arm is expected where it is by now", () => {
  const { clock, expected } = begun();
  for (let ms = 200; ms < 4000; ms += 200) {
    clock.ms = BEGAN + ms + 250;
    expected.state(told(jointsAt(PATH, ms / 1000), BEGAN + ms));
    assert.deepEqual(expected.joints, { predicted: jointsAt(PATH, (ms + 250) / 1000) });
  }
  expected.state(told(jointsAt(PATH, 4), BEGAN + 4100, { moving: false }));
  assert.equal(expected.runs, false);
});

test("a state on the path is shown alone; once states stay away the motion is expected again, to its end", () => {
  const { clock, expected } = begun();
  clock.ms = BEGAN + 1000;
  expected.state(told([...jointsAt(PATH, 1), 0.02], BEGAN + 1000)); // with the fingers, of which the path says nothing
  assert.equal(expected.joints, null);
  clock.ms += 400;
  assert.deepEqual(expected.joints, { predicted: jointsAt(PATH, 1.4) });
  expected.state(told([1, 0.5], BEGAN + 4000, { moving: false }));
  clock.ms = BEGAN + 9000;
  assert.equal(expected.joints, null);
  assert.equal(expected.runs, false);
});

test("a state from before the motion neither confirms nor ends it", () => {
  const { clock, expected } = begun();
  expected.state(told([3, 3], BEGAN - 1));
  clock.ms += 10;
  assert.ok(expected.joints);
});

test("a tool 10 mm off or a joint 2 degrees off ends it; what is nearer does not", () => {
  const [q1 = 0, q2 = 0] = jointsAt(PATH, 4);
  for (const [off, ends] of [
    [[0.021, 0], true],
    [[0.019, 0], false],
    [[0, 0.036], true],
    [[0, 0.034], false],
  ] as const) {
    const { expected } = begun();
    expected.state(told([q1 + off[0], q2 + off[1]], BEGAN + 6000));
    assert.equal(expected.runs, !ends, `${off}`);
  }
});

test("times of path and state may differ by 150 ms, not more", () => {
  for (const [late, ends] of [
    [150, false],
    [400, true],
  ] as const) {
    const { expected } = begun();
    expected.state(told(jointsAt(PATH, 2 - late / 1000), BEGAN + 2000));
    assert.equal(expected.runs, !ends, `${late} ms late`);
  }
});

test("a stop ends it, and a command that was held or failed, even if that is told before its path", () => {
  const stopped = begun().expected;
  stopped.state(told(jointsAt(PATH, 1), BEGAN + 1000, { stopped: true }));
  assert.equal(stopped.runs, false);
  for (const state of ["cancelled", "failed", "unknown", "rejected", "expired"]) {
    const { expected } = begun();
    expected.command({ id: 8, state });
    assert.equal(expected.runs, true, "another command");
    expected.command({ id: 2 ** 32 + 7, state });
    assert.equal(expected.runs, false, state);
    expected.begin(PATH);
    assert.equal(expected.runs, false, `${state}, and its path comes again`);
  }
});

test("that the command is completed confirms nothing: only a state does", () => {
  const { clock, expected } = begun();
  clock.ms = BEGAN + 5000;
  expected.command({ id: 7, state: "completed" });
  assert.deepEqual(expected.joints, { predicted: [1, 0.5] });
});

test("another motion takes its place, and a path that comes twice begins once", () => {
  const { clock, expected } = begun();
  expected.state(told(jointsAt(PATH, 1), BEGAN + 1000));
  clock.ms = BEGAN + 1100;
  expected.begin({ ...PATH });
  assert.equal(expected.joints, null);
  expected.begin({
    ...PATH,
    command: 8,
    beganMs: BEGAN + 1000,
    knots: [
      [0.2, 0.1],
      [0, 0],
    ],
  });
  assert.deepEqual(expected.joints, {
    predicted: jointsAt(
      {
        ...PATH,
        knots: [
          [0.2, 0.1],
          [0, 0],
        ],
      },
      0.1,
    ),
  });
});

const ASKED = { ...PATH, knots: [[0, 0], [0.4, 0.2]], seconds: 2 }; // prettier-ignore

/** Return a prediction that was asked to expect `ASKED` as command 3, which arrives at `BEGAN`; with its clock. */
function asked(lateMs = 0): { clock: { ms: number }; expected: Prediction } {
  const clock = { ms: BEGAN - lateMs },
    expected = new Prediction(
      () => clock.ms,
      () => null,
    );
  expected.ask(3, [0, 0], lateMs, () => ({ joints: [0.4, 0.2], seconds: 2 }));
  return { clock, expected };
}

test("a motion that was just sent is expected at once, from when it may have arrived, and its path takes its place", () => {
  const { clock, expected } = asked(100);
  assert.deepEqual(expected.joints, { predicted: [0, 0] });
  clock.ms = BEGAN + 1000;
  expected.state(told([0, 0], BEGAN, { moving: false })); // of a time before the command arrived
  assert.deepEqual(expected.joints, { predicted: jointsAt(ASKED, 1) });
  expected.begin({ ...PATH, beganMs: BEGAN + 300 });
  assert.deepEqual(expected.joints, { predicted: jointsAt(PATH, 0.7) });
});

test("a motion that was sent is expected no more once it is refused, ended or stopped, or nothing has come of it for 5 s", () => {
  for (const state of ["rejected", "expired", "failed", "cancelled", "unknown", "completed"]) {
    const { expected } = asked();
    expected.command({ id: 9, seq: 2, state });
    expected.command({ id: 9, seq: 3, state: "executing" });
    assert.equal(expected.runs, true, "another command, and one that goes on");
    expected.command({ id: 9, seq: 3, state });
    assert.deepEqual([expected.runs, expected.joints], [false, null], state);
  }
  const stopped = asked().expected;
  stopped.state(told([0, 0], BEGAN, { stopped: true }));
  assert.equal(stopped.runs, false);
  const { clock, expected } = asked();
  clock.ms = BEGAN + 4999;
  assert.equal(expected.runs, true);
  clock.ms = BEGAN + 5000;
  assert.deepEqual([expected.runs, expected.joints], [false, null]);
});

test("the next motion begins where the arm is expected; one whose end or time is not known is not expected", () => {
  const { clock, expected } = asked();
  clock.ms = BEGAN + 3000; // the motion is over, and no state has come
  let begins: readonly number[] = [];
  expected.ask(4, [0, 0], 0, (from) => ({ joints: (begins = from), seconds: 1 }));
  assert.deepEqual([begins, expected.joints], [[0.4, 0.2], { predicted: [0.4, 0.2] }]);
  for (const plan of [
    { joints: null, seconds: 1 },
    { joints: [1, 1], seconds: NaN },
  ]) {
    const nothing = new Prediction(Date.now, () => null);
    nothing.ask(1, [0, 0], 0, () => plan);
    assert.equal(nothing.runs, false);
  }
});
