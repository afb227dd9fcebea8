/** Goals, places on the plate, and tasks recorded from the ghost: what is missing in words, and the lines that are written. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { type GoalFacts, nearestTurn, newlyWon, partsInWords, progress, reachedIn } from "../src/scene/goals.ts";
import { distance, moved } from "../src/scene/moves.ts";
import type { ObjectFacts } from "../src/scene/known.ts";
import { type Beside, SceneObjects } from "../src/scene/objects.ts";
import { nearestStud, stepFor } from "../src/scene/placing.ts";
import { inverse, poseAt, product, uprightAt } from "../src/scene/poses.ts";
import { Recorder } from "../src/scene/recorder.ts";
import type { Placed } from "../src/socket/objects.ts";
import { parseTask, printTask } from "../src/widgets/task_text.ts";
import { boxFacts, objectPacket } from "./helpers.ts";

const DOWN = poseAt([0, 0, 0.001], [1, 0, 0, 0]),
  BOX = { low: [-1, -1, -0.1], size: [2, 2, 1.5] } as const;
const brick = (name: string, number: number): ObjectFacts =>
  boxFacts(name, number, { size: [0.0636, 0.0318, 0.0192], turns: 2, grasps: [[...DOWN]] });
const rod: ObjectFacts = { ...brick("rod", 2), size: [0.014, 0.014, 0.3], turns: 1, carries: [], hangs: true };
const plate = { place: [0.42, -0.36, 0] as [number, number, number], studs: [10, 10] as [number, number], pitch: 0.0159, thick: 0.004 };
const figure: GoalFacts = {
  name: "figure",
  title: "The figure",
  kind: "build",
  parts: [
    { object: "a", pose: [...uprightAt([0.3882, -0.36, 0.0136], 0)] },
    { object: "b", pose: [...uprightAt([0.42, -0.36, 0.0328], 0)] },
  ],
};
const RELEASE = -0.0015;

function cell(beside: Beside = { plate, goals: [figure], table_m: 0 }): SceneObjects {
  const made = new SceneObjects([brick("a", 0), brick("b", 1), rod], { low: [...BOX.low], size: [...BOX.size] }, RELEASE, beside);
  const lying = (y: number): Placed => ({ place: [0.6, y, 0.0096], rotation: [0, 0, 0, 1] });
  const hanging: Placed = { place: [0.55, 0.3, 0.3], rotation: [0, Math.SQRT1_2, 0, Math.SQRT1_2] };
  assert.ok(made.take("objects", { key: true, data: objectPacket([[0, lying(-0.24)], [1, lying(-0.16)], [2, hanging]], BOX) })); // prettier-ignore
  return made;
}
const pose = (made: SceneObjects, name: string) => made.all.find(({ facts }) => facts.name === name)!.pose;
const over = (at: Float64Array): Float64Array => product(at, DOWN);
/** The pose of the tool that lets go of what it holds there, as it is pressed on. */
const pressed = (made: SceneObjects, at: Float64Array): Float64Array =>
  moved(product(at, inverse(made.held!.pose)), [0, 0, RELEASE, 0, 0, 0]);
const tell = (made: SceneObjects, goals: unknown): boolean =>
  made.take("beliefs", { key: true, data: new TextEncoder().encode(JSON.stringify({ objects: {}, goals })) });

test("what is missing of a figure is said for each part, and the server alone says what is there", () => {
  const made = cell();
  assert.equal(progress(figure), "0 of 2");
  assert.equal(partsInWords(figure, made.all)[0], "a: 212 mm back, 120 mm right, 4 mm up");
  assert.ok(tell(made, { figure: { there: ["a"], won_ms: null } }));
  const reached = made.reached!["figure"];
  assert.equal(progress(figure, reached), "1 of 2");
  assert.deepEqual(partsInWords(figure, made.all, reached)[0], "✓ a: in its place");
  assert.equal(partsInWords(figure, [], reached)[1], "b: nobody knows where it is");
});

test("a turn after which a part looks the same is not missing", () => {
  const goal = uprightAt([0, 0, 0], 0),
    there = uprightAt([0, 0, 0], Math.PI - 0.05);
  assert.ok(Math.abs(distance(there, nearestTurn(goal, 2, there)).rad - 0.05) < 1e-9);
  assert.ok(distance(there, nearestTurn(goal, 1, there)).rad > 3);
});

test("a win is news once, not when the page opens, and again when it is won again", () => {
  const told = (won_ms: number | null) => reachedIn({ figure: { there: [], won_ms } });
  assert.deepEqual(newlyWon([figure], null, told(5000)), []);
  assert.deepEqual(newlyWon([figure], told(null), told(5000)), [figure]);
  assert.deepEqual(newlyWon([figure], told(5000), told(5000)), []);
  assert.deepEqual(newlyWon([figure], told(5000), told(9000)), [figure]);
});

test("what a packet says of goals is bounded and of the right kind", () => {
  assert.deepEqual(reachedIn(undefined), {});
  assert.deepEqual(reachedIn({ figure: null, rod: { there: "all", won_ms: "now" } }), {
    figure: { there: [], wonMs: null },
    rod: { there: [], wonMs: null },
  });
  assert.deepEqual(reachedIn({ figure: { there: ["a", 3], won_ms: 7 } }), { figure: { there: ["a"], wonMs: 7 } });
});

test("the nearest place on the studs, as the planner has it", () => {
  const [a] = cell().all;
  for (const [column, row, turned] of [
    [2, 5, 0],
    [7, 9, 0],
    [1, 1, 90],
    [9, 7, 90],
  ] as const) {
    // prettier-ignore
    const wide = turned ? [2, 4] : [4, 2],
      middle = [column, row].map((n, i) => plate.place[i]! + plate.pitch * (n - 1 - 5 + wide[i]! / 2)),
      at = uprightAt([middle[0]! + 0.004, middle[1]! - 0.005, 0.02], (turned * Math.PI) / 180 + 0.2);
    const near = nearestStud(plate, a!.facts, at)!;
    assert.deepEqual([near.stud, Math.round(near.turned)], [[column, row], turned]);
    assert.ok(Math.hypot(near.at[3]! - middle[0]!, near.at[7]! - middle[1]!) < 1e-9);
  }
  assert.equal(nearestStud(plate, a!.facts, uprightAt([0.6, -0.36, 0.02], 0)), null);
});

/** Return a cell, and a recorder by which the ghost's gripper has taken an object. */
function holding(name: string): { made: SceneObjects; recorder: Recorder } {
  const made = cell(),
    recorder = new Recorder(made);
  recorder.begin();
  recorder.grip(over(pose(made, name)));
  return { made, recorder };
}

test("an object in the ghost's gripper snaps to its place in the figure and to the studs", () => {
  const { made } = holding("a");
  const tool = pressed(made, uprightAt([0.3892, -0.36, 0.0136], 0));
  assert.equal(made.goal(tool)!.what, "its place in the figure");
  assert.deepEqual([...made.goal(tool)!.pose].map((v) => v.toFixed(6)), [...moved(tool, [-0.001, 0, 0, 0, 0, 0])].map((v) => v.toFixed(6))); // prettier-ignore
  const elsewhere = pressed(made, uprightAt([0.452, -0.409, 0.0136], 0));
  assert.match(made.goal(elsewhere)!.what, /^the studs at column 6, row 2$/);
});

test("of goals as good as at one place the figure's is named, of goals a millimetre apart the nearest", () => {
  for (const [aside, named] of [
    [0.0005, /figure/],
    [0.0012, /studs/],
  ] as const) {
    const [first] = figure.parts,
      beside = { ...figure, parts: [{ ...first!, pose: [...moved(Float64Array.from(first!.pose), [aside, 0, 0, 0, 0, 0])] }] };
    const made = cell({ plate, goals: [beside], table_m: 0 });
    made.restore(made.copy());
    made.hold("a", over(pose(made, "a")));
    assert.match(made.goal(pressed(made, uprightAt([0.3882, -0.36, 0.0136], 0)))!.what, named, `${aside}`);
  }
});

test("the place of a part is offered once what is beneath it is there", () => {
  const { made, recorder } = holding("b");
  const tool = pressed(made, uprightAt([0.42, -0.36, 0.0328], 0));
  assert.doesNotMatch(made.goal(tool)!.what, /figure/);
  recorder.undo();
  recorder.grip(over(pose(made, "a")));
  recorder.grip(pressed(made, uprightAt([0.3882, -0.36, 0.0136], 0)));
  recorder.grip(over(pose(made, "b")));
  assert.match(made.goal(tool)!.what, /figure/);
});

test("grasp and put are recorded as lines of a task, from the ghost alone", () => {
  const made = cell(),
    recorder = new Recorder(made);
  recorder.begin();
  assert.equal(recorder.grip(uprightAt([0.5, 0, 0.2], 0)), "Nothing is between the fingers of the ghost: put it at a grasp first."); // prettier-ignore
  assert.notEqual(typeof recorder.grip(moved(over(pose(made, "a")), [0.002, 0, 0, 0, 0, 0])), "string");
  assert.equal(made.held!.facts.name, "a");
  assert.ok(made.held!.planned);
  assert.match(String(recorder.grip(pressed(made, uprightAt([0.5, 0, 0.2], 0)))), /^Nothing is beneath a/);
  recorder.move(pressed(made, uprightAt([0.5, 0, 0.2], 0)));
  recorder.grip(pressed(made, uprightAt([0.3882, -0.36, 0.0136], 0)));
  assert.equal(made.held, null);
  recorder.grip(over(pose(made, "b")));
  recorder.grip(pressed(made, uprightAt([0.42, -0.36, 0.0328], 0)));
  const text = printTask(recorder.steps);
  assert.equal(text, ["grasp a", "move 500 0 199.5 180 0 0", "put a on plate at 2 5", "grasp b", "put b on a by 31.8 0"].join("\n")); // prettier-ignore
  assert.deepEqual(parseTask(text), recorder.steps);
  assert.ok(Math.abs(pose(made, "b")[11]! - 0.0328) < 1e-9, "it is drawn where it lies");
  recorder.end();
  assert.ok(Math.abs(pose(made, "a")[3]! - 0.6) < 1e-4, "nothing has moved in truth");
});

test("an object under another one cannot be taken, and a record is taken back with what it did", () => {
  const { made, recorder } = holding("a");
  recorder.grip(pressed(made, moved(pose(made, "b"), [0, 0, 0.0192, 0, 0, 0])));
  assert.equal(printTask(recorder.steps), "grasp a\nput a on b");
  assert.equal(recorder.grip(over(pose(made, "b"))), "a lies on b.");
  recorder.undo();
  assert.equal(made.held?.facts.name, "a");
  recorder.undo();
  assert.equal(made.held, null);
  assert.ok(Math.abs(pose(made, "a")[3]! - 0.6) < 1e-4);
  assert.equal(recorder.undo(), null);
  assert.deepEqual(recorder.steps, []);
});

test("steps on the table, beside the studs, turned, and of a rod that may be let go anywhere", () => {
  const made = cell(),
    [a, b] = made.all,
    around = { plate, table: 0, lying: [b!] };
  const step = (at: Float64Array): string | null => {
    const found = stepFor(a!.facts, at, around);
    return found && printTask([found]);
  };
  assert.equal(step(uprightAt([0.5, 0.05, 0.0096], Math.PI / 4)), "put a at 500 50 45");
  assert.equal(step(uprightAt([0.42 + 0.006, -0.36, 0.0136], 0)), null);
  assert.equal(step(uprightAt([0.42 + 0.0159, -0.36, 0.0136], Math.PI / 2)), "put a on plate at 6 4 turned 90");
  assert.equal(step(uprightAt([0.6, -0.16, 0.0288], Math.PI / 2)), "put a on b turned 90");
  assert.equal(step(uprightAt([0.5, 0.05, 0.1], 0)), null);
  const recorder = new Recorder(made);
  recorder.begin();
  const grasp = over(pose(made, "rod")),
    lifted = moved(grasp, [0, 0, 0.02, 0, 0, 0]);
  recorder.grip(grasp);
  recorder.grip(lifted);
  assert.equal(printTask(recorder.steps), "grasp rod\nmove 551 300 320 0 90 -180\nopen");
});
