/** Where the robot was before its last move; steps whose size is said, asked about and forgotten; places offered again. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { WayBack } from "../src/page/way_back.ts";
import { placesAfter } from "../src/widgets/place_rules.ts";
import { isLarge, StepSize } from "../src/widgets/steps.ts";
import { seededDraw } from "./helpers.ts";

const NEAR = 0.002;
const ENDS = ["completed", "failed", "cancelled", "unknown"];

/** A robot that moves where a command says. */
class Robot {
  at = [0];
  seq = 0;
  way = new WayBack(["move"], () => this.at);

  readonly grant = 3;

  constructor() {
    this.way.turn(this.grant);
  }

  tell(seq: number, state: string, kind = "move"): void {
    this.way.take({ seq, kind, state, grant: this.grant });
  }

  begin(kind = "move"): number {
    this.seq += 1;
    for (const state of ["sending", "accepted", "sent", "acknowledged"]) this.tell(this.seq, state, kind);
    return this.seq;
  }

  move(to: number, end = "completed", kind = "move"): void {
    const seq = this.begin(kind);
    this.at = [to];
    this.tell(seq, end, kind);
  }
}

test("before the first move there is nothing to go back to, and after one there is", () => {
  const robot = new Robot();
  assert.match(robot.way.whyNot(NEAR), /nothing to go back to/);
  const seq = robot.begin();
  robot.at = [0.5];
  assert.match(robot.way.whyNot(NEAR), /nothing to go back to/, "it has not ended");
  robot.tell(seq, "completed");
  assert.deepEqual([robot.way.joints, robot.way.whyNot(NEAR)], [[0], ""]);
});

test("however a move has ended, the way back leads to where it began; one that never began changes nothing", () => {
  for (const end of ENDS) {
    const robot = new Robot();
    robot.move(1, end);
    assert.deepEqual(robot.way.joints, [0], end);
  }
  for (const end of ["rejected", "expired"]) {
    const robot = new Robot();
    robot.move(1);
    robot.move(1, end);
    assert.deepEqual(robot.way.joints, [0], end);
  }
});

test("going back is a move, too: the next way back leads to where that one began", () => {
  const robot = new Robot();
  robot.move(1);
  robot.move(robot.way.joints![0]!);
  assert.deepEqual(robot.way.joints, [1]);
  robot.move(1);
  robot.move(1);
  assert.match(robot.way.whyNot(NEAR), /is where it was/);
});

test("what is held, or moves elsewhere, is not gone back from", () => {
  const robot = new Robot();
  robot.move(1);
  robot.move(4, "completed", "jog");
  assert.deepEqual(robot.way.joints, [0]);
});

test("a move that replaces another one began where that one did, for it was never at rest between", () => {
  const robot = new Robot();
  robot.move(1);
  const first = robot.begin();
  robot.at = [1.4];
  const second = robot.begin();
  robot.tell(first, "cancelled");
  robot.at = [3];
  robot.tell(second, "completed");
  assert.deepEqual(robot.way.joints, [1]);
});

test("a refusal in the portal leaves no start behind, and a command that was never seen to begin has none", () => {
  const robot = new Robot();
  robot.tell(1, "sending");
  robot.way.take({ seq: 1, kind: "", state: "rejected", grant: robot.grant });
  robot.at = [2];
  robot.seq = 1;
  robot.move(3);
  assert.deepEqual(robot.way.joints, [2]);
  robot.tell(9, "acknowledged");
  robot.tell(9, "completed");
  assert.deepEqual(robot.way.joints, [2]);
});

test("another turn forgets, and the same one again does not", () => {
  const robot = new Robot();
  robot.move(1);
  robot.way.turn(3);
  assert.deepEqual(robot.way.joints, [0]);
  robot.way.turn(0);
  assert.equal(robot.way.joints, null);
  robot.move(2);
  assert.equal(robot.way.joints, null, "it is somebody else's");
});

test("a step is large by its share of the robot's own range", () => {
  const range = { low: -1.6, high: 1.6 };
  assert.deepEqual([0.005, 0.02, 0.1].map((step) => isLarge(step, range)), [false, false, true]); // prettier-ignore
});

test("a large step is asked about once, and again after another size or another turn, which begins with the usual one", () => {
  const sizes = [1, 20, 100].map((mm) => ({ mm, words: `${mm} mm`, isLarge: mm === 100 }));
  const size = new StepSize(sizes, 1);
  for (let seed = 0; seed < 200; seed++) {
    const draw = seededDraw(seed);
    size.reset();
    assert.deepEqual([size.now.mm, size.ask()], [20, ""]);
    let asked = false;
    for (let i = 0; i < 20; i++) {
      const before = size.index;
      if (draw(0, 1) < 0.5) size.choose(size.index + Math.round(draw(-1.5, 1.5)));
      if (size.index !== before) asked = false;
      const question = size.ask();
      assert.equal(question !== "", size.now.isLarge && !asked);
      if (question) assert.match(question, /100 mm/);
      asked ||= size.now.isLarge;
    }
    size.choose(99);
    assert.equal(size.now.mm, 100, "beyond the last there is none");
  }
});

test("the last places are the newest first, each once, and five at most", () => {
  for (let seed = 0; seed < 200; seed++) {
    const draw = seededDraw(seed);
    let places: readonly (readonly number[])[] = [];
    for (let i = 0; i < 12; i++) {
      const place = [Math.round(draw(0, 3)), Math.round(draw(0, 2)) + draw(-1e-3, 1e-3)];
      places = placesAfter(places, place);
      assert.equal(places[0], place);
      assert.ok(places.length <= 5);
      for (const one of places) assert.equal(places.filter((two) => Math.hypot(one[0]! - two[0]!, one[1]! - two[1]!) < 0.001).length, 1);
    }
  }
});
