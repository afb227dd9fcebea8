import assert from "node:assert/strict";
import { test } from "node:test";
import { parse, print } from "../../robots/drivers/pa10/console/program_text.ts";
import { understood } from "../../robots/drivers/pa10/console/terminal_lines.ts";
import { stick, twist } from "../src/gamepad.ts";

const pad = (axes: number[], pressed: number[] = [], connected = true) => ({
  axes, connected, buttons: Array.from({ length: 17 }, (_, i) => ({ pressed: pressed.includes(i), touched: false, value: 0 })),
});

test("a stick at rest, or one that only trembles, is no direction", () => {
  assert.equal(stick(null), null);
  assert.equal(stick(pad([0, 0])), null);
  assert.equal(stick(pad([0.2, -0.3])), null);
  assert.equal(stick(pad([1, 0], [], false)), null, "a pad that was unplugged");
});

test("up on the stick is away from the arm; the cross does the same", () => {
  assert.deepEqual(stick(pad([0, -1])), [0, 1]);
  assert.deepEqual(stick(pad([1, 0])), [1, 0]);
  assert.deepEqual(stick(pad([0, 0], [12])), [0, 1]);
  assert.deepEqual(stick(pad([0, 0], [14])), [-1, 0]);
  assert.deepEqual(stick(pad([1, -1], [15])), [1, 1], "never beyond one");
});

test("two sticks move a tool, and at rest ask for nothing", () => {
  assert.equal(twist(pad([0.1, 0.2, 0, -0.3])), null);
  assert.deepEqual(twist(pad([0, -1, 0, 0])), { x: 1 });
  assert.deepEqual(twist(pad([0, 0, 0.8, 1])), { z: -1, yaw: -0.8 });
  assert.equal(twist(pad([0, -1, 0, 0], [], false)), null, "a pad that was unplugged");
});

const AXES = ["S1", "S2", "E1", "E2", "W1", "W2"];

test("a line of the terminal stands for a command in SI units, or says what is wrong", () => {
  const joints = understood("j 90 0 0 0 0 -180 0.2", AXES);
  assert.equal(joints.kind, "joints");
  assert.ok(Math.abs((joints.args["S1"] ?? 0) - Math.PI / 2) < 1e-12);
  assert.deepEqual([joints.args["W2"], joints.args["speed"]], [-Math.PI, 0.2]);
  assert.deepEqual(understood("l 500 -20 30 0 0 0", AXES).args, { x: 0.5, y: -0.02, z: 0.03, roll: 0, pitch: 0, yaw: 0 });
  assert.deepEqual(understood(" g 1 ", AXES), { kind: "gripper", args: { closed: 1 } });
  for (const [line, why] of [["j 1 2", /needs 6 or 7 numbers, not 2/], ["k 1 2 3 4 5 x", /x is not a number/], ["g", /needs 1 numbers/], ["rm -rf", /is not a number|no line/]] as const)
    assert.throws(() => understood(line, AXES), why);
});

test("a program is the same as text and as steps", () => {
  const text = "g 0\nk 500 160 150 180 0 180 0.3\nR 3\nl 500 160 20 180 0 180\nR 2\nd 0.5\nE\nE\nj 0 25 75 0 80 0\nK 1 2 3 4 5 6";
  assert.equal(print(parse(text)), text);
  assert.equal(print(parse("  g 1  # close\n\n# nothing\nj 1.23456 0 0 0 0 -0.1")), "g 1\nj 1.235 0 0 0 0 -0.1");
  for (const [bad, why] of [
    ["j 1 2", /Line 1: j needs 6 or 7/], ["g 1\nx 2", /Line 2: there is no step/], ["R 2\ng 1", /no end/], ["E", /there is none/],
    ["R 0\nE", /1 to 100/], ["d soon", /“soon” is not a number/],
  ] as const)
    assert.throws(() => parse(bad), why);
});
