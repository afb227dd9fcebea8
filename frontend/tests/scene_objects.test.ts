/** The objects in an arm's scene: read from packets, what the ghost snaps to, what is missing in words. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { Ghost } from "../src/scene/ghost.ts";
import { distance, moved } from "../src/scene/moves.ts";
import type { ObjectFacts } from "../src/scene/known.ts";
import { isSaidAt, missingInWords, SceneObjects, SNAP_M, snapped, snappedStep } from "../src/scene/objects.ts";
import { inverse, poseAt, product, uprightAt } from "../src/scene/poses.ts";
import type { Placed } from "../src/socket/objects.ts";
import { boxFacts, bytesOf, objectPacket, vectorsOf } from "./helpers.ts";

const DOWN = poseAt([0, 0, 0.002], [1, 0, 0, 0]); // the tool points down, in the object's frame
const BOX = { low: [-1, -1, -0.1], size: [2, 2, 1.5] } as const;
const brick = (name: string, number: number): ObjectFacts => {
  const first = [...poseAt([0.5, 0.3, 0.02], [0, 0, 0, 1])];
  return boxFacts(name, number, { size: [0.04, 0.04, 0.04], turns: 4, first, grasps: [[...DOWN]] });
};

function scene(...objects: (readonly [number, Placed])[]): SceneObjects {
  const made = new SceneObjects([brick("red", 0), brick("blue", 1), brick("green", 2)], { low: [...BOX.low], size: [...BOX.size] }, 0.001);
  assert.ok(made.take("objects", { key: true, data: objectPacket(objects, BOX) }));
  return made;
}
const lying = (x: number, y: number, z = 0.02, angle = 0): Placed => ({
  place: [x, y, z],
  rotation: [0, 0, Math.sin(angle / 2), Math.cos(angle / 2)],
});
const inGripper: Placed = { place: [0, 0, 0.002], rotation: [1, 0, 0, 0], held: true };

test("poses and their inverses", () => {
  const pose = poseAt([0.1, -0.2, 0.3], [0.5, 0.5, 0.5, 0.5]),
    none = product(pose, inverse(pose));
  assert.ok(distance(none, uprightAt([0, 0, 0], 0)).m < 1e-12);
  assert.ok(distance(product(inverse(pose), pose), uprightAt([0, 0, 0], 0)).rad < 1e-7);
});

test("objects are where their packets say; what cannot be read changes nothing", () => {
  const objects = scene([0, lying(0.5, 0.1)], [1, inGripper]);
  const [red, blue] = objects.all;
  assert.deepEqual([red!.pose[3], red!.pose[7], red!.pose[11]].map((v) => v!.toFixed(3)), ["0.500", "0.100", "0.020"]); // prettier-ignore
  assert.deepEqual([red!.held, blue!.held, objects.held?.facts.name], [false, true, "blue"]);
  assert.equal(objects.take("objects", { key: false, data: new Uint8Array(5) }), false);
  assert.equal(objects.take("beliefs", { key: true, data: new TextEncoder().encode("{") }), false);
  assert.equal(objects.take("trace", { key: true, data: new Uint8Array() }), false);
  assert.equal(objects.all.length, 2);
  const told = { objects: { red: { how: "placed by the arm", at_ms: 5000 }, blue: null } };
  assert.ok(objects.take("beliefs", { key: true, data: new TextEncoder().encode(JSON.stringify(told)) }));
  assert.deepEqual(objects.all.map(({ how, atMs }) => [how, atMs]), [["placed by the arm", 5000], ["", NaN]]); // prettier-ignore
});

test("an object whose place nobody knows is told with the reason", () => {
  const objects = scene([0, lying(0.5, 0.1)]);
  assert.deepEqual(objects.lost, [], "nothing was told of them");
  const told = { objects: { red: { how: "measured", at_ms: 1 }, blue: { how: "not seen where it was", at_ms: 2 }, green: null } };
  assert.ok(objects.take("beliefs", { key: true, data: new TextEncoder().encode(JSON.stringify(told)) }));
  assert.deepEqual(objects.lost, [{ name: "blue", how: "not seen where it was" }]);
});

test("packets are those that Python writes", () => {
  const { packets, box } = vectorsOf<{
    box: { low: [number, number, number]; size: [number, number, number] };
    packets: { key: boolean; hex: string }[];
  }>("object_packets");
  const objects = new SceneObjects([brick("red", 0)], box, 0);
  for (const { key, hex } of packets) assert.ok(objects.take("objects", { key, data: bytesOf(hex) }));
});

test("an empty gripper is led to the nearest grasp, turned as little as it can be", () => {
  const objects = scene([0, lying(0.5, 0.1, 0.02, 0.8)], [1, lying(0.6, -0.2)]),
    grasp = product(poseAt([0.5, 0.1, 0.02], [0, 0, Math.sin(0.4), Math.cos(0.4)]), DOWN),
    tool = moved(grasp, [0, 0, 0.05, 0, 0, 0.1]);
  const goal = objects.goal(tool)!;
  assert.equal(goal.what, "the grasp of red");
  const far = distance(goal.pose, grasp);
  assert.ok(far.m < 1e-4 && far.rad < 1e-3);
  assert.equal(missingInWords(tool, goal), "To the grasp of red: 50 mm down, -6° about z.");
  const turned = objects.goal(moved(tool, [0, 0, 0, 0, 0, Math.PI / 2]))!;
  assert.ok(distance(turned.pose, moved(grasp, [0, 0, 0, 0, 0, Math.PI / 2])).rad < 1e-3, "a quarter turn looks the same");
});

test("an object that is held is led onto a free one, not onto one that carries another, and back to where it was first", () => {
  const objects = scene([0, lying(0.5, 0.1)], [1, lying(0.5, 0.1, 0.06)], [2, inGripper]),
    above = (x: number, y: number, z: number): Float64Array => poseAt([x, y, z], [1, 0, 0, 0]);
  const goal = objects.goal(above(0.5, 0.1, 0.12))!;
  assert.equal(goal.what, "on blue");
  assert.ok(Math.abs(goal.pose[11]! - (0.06 + 0.04 + 0.001 + 0.002)) < 3e-4, `${goal.pose[11]}`);
  assert.equal(objects.goal(above(0.5, 0.29, 0.05))!.what, "where green was first");
});

test("near a goal the ghost snaps to it, and a step away is a step away", () => {
  const goal = { pose: poseAt([0.5, 0, 0.1], [1, 0, 0, 0]), what: "on blue" },
    near = moved(goal.pose, [0.0015, 0, 0, 0, 0, 0.02]),
    far = moved(goal.pose, [SNAP_M * 1.1, 0, 0, 0, 0, 0.03]);
  assert.equal(snapped(near, goal), goal.pose);
  assert.equal(snapped(far, goal), far);
  assert.equal(snapped(near, null), near);
  assert.equal(snappedStep(near, goal, far), goal.pose, "a step towards it");
  assert.equal(snappedStep(near, goal, goal.pose), near, "a step away");
  const ghost = new Ghost(
    () => ({ verdict: "free", text: "", joints: null, path: [], seconds: 1 }),
    (pose, from) => snappedStep(pose, goal, from),
  );
  ghost.follow(goal.pose);
  for (let n = 0; n < 5; n++) ghost.step([0.001, 0, 0, 0, 0, 0]);
  assert.ok(Math.abs(ghost.pose![3]! - 0.505) < 1e-12, "short steps leave it");
  for (let n = 0; n < 5; n++) ghost.step([-0.001, 0, 0, 0, 0, 0]);
  assert.ok(distance(ghost.pose!, goal.pose).m < SNAP_M, "and come back to it");
});

test("what words say to be at a goal is sent from exactly there, and nothing else is moved", () => {
  const goal = { pose: poseAt([0.5, 0, 0.1], [1, 0, 0, 0]), what: "on blue" },
    almost = moved(goal.pose, [0.0004, -0.0004, 0.0004, 0, 0, 0.008]),
    beside = moved(goal.pose, [0.0007, 0, 0, 0, 0, 0]);
  assert.equal(missingInWords(almost, goal), "The ghost is at on blue.");
  assert.equal(missingInWords(beside, goal), "To on blue: 1 mm back.");
  const exact = (pose: Float64Array): Float64Array => (isSaidAt(pose, goal) ? goal.pose : pose);
  let verdict: "free" | "way" | "refused" = "free";
  const ghost = new Ghost(() => ({ verdict, text: "no", joints: null, path: [], seconds: 1 }));
  ghost.follow(almost);
  ghost.moveToGoal(exact);
  assert.equal(ghost.pose, almost, "a ghost at the arm stays there");
  for (const [from, to] of [
    [almost, goal.pose],
    [beside, beside],
  ] as const) {
    ghost.put(from);
    ghost.moveToGoal(exact);
    assert.equal(ghost.pose, to);
    assert.equal(ghost.snapped, to === goal.pose);
  }
  for (const refused of ["refused", "way"] as const) {
    verdict = "free";
    ghost.put(almost);
    verdict = refused;
    ghost.moveToGoal(exact);
    assert.equal(ghost.pose, almost, `${refused}: the arm does not come exactly there`);
    assert.equal(ghost.refusal, "");
  }
});
