import assert from "node:assert/strict";
import { test } from "node:test";
import { parse, print } from "../../robots/kit/drivers/pa10/console/program_text.ts";
import { understood } from "../../robots/kit/drivers/pa10/console/terminal_lines.ts";
import { type Pad, Pads, stick, twist } from "../src/widgets/gamepad.ts";
import { gamepad as pad } from "./helpers.ts";

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

/** A gamepad as the browser reports it. */
const reported = (axes: number[], mapping: GamepadMappingType = "standard", pressed: number[] = []): Pad => ({
  ...pad(axes, pressed),
  ...{ mapping, id: "A pad", index: 0 },
});
const twists = (pads: Pads, given: Pad): Record<string, number> | null => pads.read([given]).map(twist)[0] ?? null;

test("triggers that rest at -1 turn nothing, whichever axes they are", () => {
  const pads = new Pads(),
    firefox = (axes: number[]): Pad => reported(axes, "");
  for (const rest of ["0 0 0 0 0 0", "0 0 -1 0 0 -1", "0 0 -1 -1 0 0", "0 0 1 0 0 -1"])
    assert.equal(twists(pads, firefox(rest.split(" ").map(Number))), null, "not even one that was reported as 0 before its first press");
  assert.match(pads.why, /does not know its layout/);
  assert.deepEqual(twists(pads, firefox([0, -1, -1, 0, 0, -1])), { x: 1 }, "the left stick works");
  const crossed = pads.read([{ ...firefox([0, 0]), buttons: reported([], "", [12]).buttons }]);
  assert.deepEqual(crossed.map(stick), [null], "buttons have no known places");
});

test("an axis counts from when it was seen at rest, and again after another gamepad took its place", () => {
  const pads = new Pads(),
    pushed = reported([0, -1, 0, 0]),
    rest = reported([0, 0, 0, 0]);
  assert.equal(twists(pads, pushed), null);
  assert.match(pads.why, /release its sticks/);
  assert.equal(twists(pads, reported([0, 0.1, 0, 0])), null);
  assert.equal(pads.why, "");
  assert.deepEqual(twists(pads, pushed), { x: 1 });
  assert.equal(twists(pads, { ...pushed, id: "Another pad" }), null, "another one in its place");
  assert.equal(twists(pads, { ...rest, id: "Another pad" }), null);
  assert.deepEqual(twists(pads, { ...pushed, id: "Another pad" }), { x: 1 });
  pads.read([]);
  assert.equal(twists(pads, { ...pushed, id: "Another pad" }), null, "unplugged, and plugged in again");
  twists(pads, rest);
  pads.forget();
  assert.equal(twists(pads, pushed), null, "the controls were not enabled meanwhile");
});

test("a cross that is held down as the gamepad is connected gives no direction", () => {
  const pads = new Pads(),
    held = reported([0, 0], "standard", [12]);
  assert.deepEqual(pads.read([held]).map(stick), [null]);
  pads.read([reported([0, 0])]);
  assert.deepEqual(pads.read([held]).map(stick), [[0, 1]]);
});

const AXES = ["S1", "S2", "E1", "E2", "W1", "W2"];

test("a line of the terminal stands for a command in SI units, or says what is wrong", () => {
  const joints = understood("j 90 0 0 0 0 -180 0.2", AXES);
  assert.equal(joints.kind, "joints");
  assert.ok(Math.abs((joints.args["S1"] ?? 0) - Math.PI / 2) < 1e-12);
  assert.deepEqual([joints.args["W2"], joints.args["speed"]], [-Math.PI, 0.2]);
  assert.deepEqual(understood("l 500 -20 30 0 0 0", AXES).args, { x: 0.5, y: -0.02, z: 0.03, roll: 0, pitch: 0, yaw: 0 });
  assert.deepEqual(understood(" g 1 ", AXES), { kind: "gripper", args: { closed: 1 } });
  const wrong = {
    "j 1 2": /needs 6 or 7 numbers, not 2/,
    "k 1 2 3 4 5 x": /x is not a number/,
    g: /needs 1 numbers/,
    "rm -rf": /is not a number|no line/,
  };
  for (const [line, why] of Object.entries(wrong)) assert.throws(() => understood(line, AXES), why);
});

test("a program is the same as text and as steps", () => {
  const text = "g 0\nk 500 160 150 180 0 180 0.3\nR 3\nl 500 160 20 180 0 180\nR 2\nd 0.5\nE\nE\nj 0 25 75 0 80 0\nK 1 2 3 4 5 6";
  assert.equal(print(parse(text)), text);
  assert.equal(print(parse("  g 1  # close\n\n# nothing\nj 1.23456 0 0 0 0 -0.1")), "g 1\nj 1.235 0 0 0 0 -0.1");
  for (const [bad, why] of [
    ["j 1 2", /Line 1: j needs 6 or 7/],
    ["g 1\nx 2", /Line 2: there is no step/],
    ["R 2\ng 1", /no end/],
    ["E", /there is none/],
    ["R 0\nE", /1 to 100/],
    ["d soon", /“soon” is not a number/],
  ] as const)
    assert.throws(() => parse(bad), why);
});
