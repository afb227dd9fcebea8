/** Where the robot is and was, as pictures and states tell it. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { fromOwn, hasLeft, splitPicture, splitState } from "../src/socket/poses.ts";
import { decode } from "../src/socket/decoder.ts";
import type { PicturePacket, StatePacket } from "../src/socket/packets.ts";
import { bytesOf, vectorsOf } from "./helpers.ts";

interface Told {
  what: string;
  hex: string;
  joints: number[];
  pose: number[];
  twist: number[];
  channels: string[];
  values: (number | null)[];
}
const packet = (one: Told): unknown => decode(bytesOf(one.hex).buffer);

test("a picture's joints, pose and velocity are told apart by what the spec declares", () => {
  for (const one of vectorsOf<Told[]>("picture_packets")) {
    const { joints, pose, twist } = splitPicture(packet(one) as PicturePacket, one.joints.length, one.pose.length);
    assert.deepEqual([joints, pose, twist], [one.joints, one.pose, one.twist], one.what);
  }
});

test("a state's velocity is no value of a channel", () => {
  for (const one of vectorsOf<Told[]>("state_packets")) {
    const { values, twist } = splitState(packet(one) as StatePacket, one.channels.length);
    assert.deepEqual([values.map((v) => (Number.isNaN(v) ? null : v)), twist], [one.values, one.twist], one.what);
  }
});

test("a robot in the plane has left a picture's place once it has rolled or turned", () => {
  const units = ["m", "m", "rad"],
    then = [1, 2, 3.14];
  for (const [now, wanted] of [
    [[1, 2, 3.14], false],
    [[1.01, 2.01, 3.14], false],
    [[1.1, 2, 3.14], true],
    [[1, 2, 3.3], true],
    [[1, 2, -3.14], false],
    [[1, 2], false],
    [[], false],
    [[NaN, 2, 3.14], false],
  ] as [number[], boolean][])
    assert.equal(hasLeft(then, now, units), wanted, `${now}`);
  assert.equal(hasLeft([], [1, 2, 3], units), false, "what is not known says nothing");
  assert.equal(hasLeft(then, [1.1, 2, 3.14], units, { m: 0.2, rad: 0.05 }), false);
});

test("a path in the robot's own frame lies where the robot is", () => {
  const here = [1, 2, Math.PI / 2];
  const [[start], [end]] = [
    [0, 0, 0],
    [0.5, 0.25, 0.1],
  ].map((pose) => fromOwn(here, [pose])) as [number[][], number[][]];
  assert.deepEqual(start, here);
  [0.75, 2.5, Math.PI / 2 + 0.1].forEach((v, i) => assert.ok(Math.abs(end[i]! - v) < 1e-12, `${end}`));
});
