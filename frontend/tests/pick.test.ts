/** Clicks in calibrated pictures, and what a gripper says in words. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { type Grip, gripInShort, gripInWords, gripOf, isLoaded } from "../src/scene/gripper.ts";
import { type Camera, inPicture, type Place, placeAt, placeInWords, topOf } from "../src/scene/sight.ts";
import { type KnownObject, seenInWords } from "../src/scene/known.ts";
import { poseAt } from "../src/scene/poses.ts";
import { boxFacts, vectorsOf } from "./helpers.ts";

interface Projected {
  cameras: (Camera & { size: [number, number] })[];
  points: { camera: string; at: [number, number, number]; uv: [number, number] | null }[];
}
const { cameras, points } = vectorsOf<Projected>("camera_points");
const ABOVE: Camera = { name: "above", place: [0.5, -0.001, 1], at: [0.5, 0, 0], field_deg: 60 };
const block = (name: string, number: number, x: number, y: number, z = 0.02, held = false): KnownObject => ({
  facts: boxFacts(name, number, { size: [0.04, 0.04, 0.04], turns: 4 }),
  pose: poseAt([x, y, z], [0, 0, 0, 1]),
  held,
  how: "measured",
  atMs: 0,
});
const near = (one: readonly number[], other: readonly number[], by: number): void =>
  assert.ok(
    one.every((v, i) => Math.abs(v - other[i]!) < by),
    `${one.join()} is not ${other.join()}`,
  );

test("a place is where Python's camera has it in the picture, and the click there gives the place again", () => {
  for (const { camera: name, at, uv } of points) {
    const camera = cameras.find((one) => one.name === name)!,
      [width, height] = camera.size,
      found = inPicture(camera, at, width / height);
    if (!uv) {
      assert.equal(found, null);
      continue;
    }
    near([found![0] * width - 0.5, found![1] * height - 0.5], uv, 1e-6); // Python counts from the middle of a pixel
    const back = placeAt(camera, found!, width / height, { known: [], plate: null, table: at[2] });
    if (back) near(back.at, at, 1e-6);
  }
});

test("what is nearest to the camera is chosen: the upper of two blocks, none that is held, else the table", () => {
  const known = [
    block("red", 0, 0.5, 0),
    block("blue", 1, 0.5, 0, 0.06),
    block("green", 2, 0.6, 0.1),
    block("held", 3, 0.3, 0.1, 0.02, true),
  ];
  const click = (x: number, y: number): Place =>
    placeAt(ABOVE, inPicture(ABOVE, [x, y, 0], 4 / 3)!, 4 / 3, { known, plate: null, table: 0 })!;
  assert.deepEqual([click(0.5, 0).object, click(0.6, 0.1).object, click(0.3, 0.1).object], ["blue", "green", ""]);
  near(click(0.61, 0.095).at, [0.6, 0.1, 0.04], 1e-9); // the middle of its top
  near(topOf(known[1]!), [0.5, 0, 0.08], 1e-9);
  near(click(0.42, -0.2).at, [0.42, -0.2, 0], 1e-9);
});

test("a plate is higher than the table around it; above the horizon there is nothing", () => {
  const plate = { place: [0.5, 0, 0] as [number, number, number], studs: [10, 10] as [number, number], pitch: 0.016, thick: 0.004 };
  const at = (x: number, y: number): number => placeAt(ABOVE, inPicture(ABOVE, [x, y, 0], 1)!, 1, { known: [], plate, table: 0 })!.at[2];
  near([at(0.5, 0.05), at(0.5, 0.2)], [0.004, 0], 1e-9);
  const level: Camera = { name: "level", place: [1, 0, 0.5], at: [0, 0, 0.5], field_deg: 60 };
  assert.equal(placeAt(level, [0.5, 0.2], 1, { known: [], plate: null, table: 0 }), null);
  assert.equal(inPicture(level, [2, 0, 0], 1), null);
});

test("a place in words", () => {
  assert.equal(placeInWords({ at: [0.5, 0.16, 0.04], object: "red" }), "The object red, 500 mm ahead of the base, 160 mm to its left");
  assert.equal(placeInWords({ at: [-0.1, -0.08, 0], object: "" }), "The table, 100 mm behind the base, 80 mm to its right");
  assert.equal(placeInWords({ at: [0.45, 0.0002, 0], object: "" }), "The table, 450 mm ahead of the base");
});

test("fingers tell what they hold once they rest; one that tells nothing is not asked", () => {
  const facts = { joint: "gripper", open: 0.04, empty_below: 0.003 };
  assert.deepEqual(
    [0.04, 0.0385, 0.02, 0.0005].map((opening) => gripOf(facts, opening, opening)),
    ["open", "open", "holds", "empty"],
  );
  assert.equal(gripOf(facts, 0.02, 0.03), "moving");
  assert.equal(gripOf(facts, NaN, NaN), "unknown");
  assert.equal(gripOf({ open: 0.03 }, 0.02, 0.02), "unknown");
});

const GRIPS: [Grip, held: string, sentence: string, short: string, loaded: boolean][] = [
  ["holds", "red", "The gripper holds red.", "Holds red", true],
  ["holds", "", "The gripper holds something.", "Holds something", true],
  ["empty", "", "The gripper is empty.", "Empty", false],
  ["open", "", "The gripper is open and empty.", "Empty, open", false],
  ["moving", "", "The gripper moves.", "Gripper moves", false],
  ["moving", "red", "The gripper moves.", "Gripper moves", true],
  ["unknown", "", "The gripper cannot feel whether it holds something.", "", false],
  ["unknown", "red", "The gripper should hold red; it cannot feel.", "Should hold red", true],
  ["empty", "red", "The gripper is empty: it feels nothing, red was expected.", "Empty, red expected", false],
  ["open", "red", "The gripper is empty: it feels nothing, red was expected.", "Empty, red expected", false],
];

for (const [grip, held, sentence, short, loaded] of GRIPS)
  test(`what the fingers tell wins, and a belief is called one: ${grip}, ${held || "nothing"} believed`, () => {
    assert.equal(gripInWords(grip, held), sentence);
    assert.equal(gripInShort(grip, held), short);
    assert.equal(isLoaded(grip, held), loaded);
  });

test("when an object was seen is said; a place that no picture has shown has no age", () => {
  const seen = (how: string, secondsAgo: number): string => seenInWords({ how, atMs: 1e9 - 1000 * secondsAgo }, 1e9);
  assert.deepEqual(
    [seen("measured", 12), seen("measured", 119), seen("measured", 150), seen("measured", 9000), seen("measured", -3)],
    ["seen 12 s ago", "seen 119 s ago", "seen 2 min ago", "seen 2 h ago", "seen 0 s ago"],
  );
  assert.equal(seen("placed by the arm", 12), "");
  assert.equal(seen("measured", NaN), "");
});
