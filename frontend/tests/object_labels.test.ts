/** The labels of objects in the view: what is written on them. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { Group } from "three";
import type { KnownObject } from "../src/scene/known.ts";
import { poseAt } from "../src/scene/poses.ts";
import { browse } from "./browser.ts";
import { boxFacts } from "./helpers.ts";

let written: string[] = [];
const pen = {
  measureText: (text: string) => ({ width: 10 * text.length }),
  fillRect: () => undefined,
  fillText: (text: string) => written.push(text),
};
browse();
document.createElement("canvas").constructor.prototype.getContext = () => pen; // jsdom has none
const { ObjectShapes } = await import("../src/scene/object_shapes.ts");
const block = (name: string, held = false): KnownObject => ({
  facts: boxFacts(name, 0, { size: [0.04, 0.04, 0.04], turns: 4 }),
  pose: poseAt([0.5, 0, 0.02], [0, 0, 0, 1]),
  held,
  how: "measured",
  atMs: 0,
});
const shapes = new ObjectShapes(new Group(), new Group(), new Group());

beforeEach(() => (written = []));

test("a block's label has its name, and when the last picture showed it", () => {
  const age = (one: KnownObject): string => (one.facts.name === "red" ? "seen 12 s ago" : "");
  shapes.show([block("red"), block("blue")], () => false, age);
  assert.deepEqual(written, ["red, seen 12 s ago", "blue"]);
});

test("what is held goes where the tool goes: its label has no age", () => {
  shapes.show([block("red", true)], () => false, () => "seen 12 s ago"); // prettier-ignore
  assert.deepEqual(written, ["red"]);
});
