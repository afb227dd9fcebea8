/** Motions of an arm planned in the browser: the same as Python's (tests/unit/test_arm_motion_vectors.py), and sound by themselves. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { Branches } from "../src/motion/branches.ts";
import { Chain } from "../src/motion/chain.ts";
import type { ArmFacts } from "../src/motion/facts.ts";
import { type Outcome, Planner } from "../src/motion/planner.ts";
import { fixed, general } from "../src/motion/words.ts";
import { seededDraw, vectorsOf } from "./helpers.ts";
import { type Answers, answers, type Case } from "./motion_answers.ts";

interface Vectors {
  arms: Record<string, { facts: ArmFacts; ready: number[]; cases: (Case & { answers: Answers })[] }>;
  words: [number, string, string, string, string, string][];
}
const { arms, words } = vectorsOf<Vectors>("arm_motions");

function near(found: ArrayLike<number> | undefined, wanted: ArrayLike<number>, within: number, what: string): void {
  assert.equal(found?.length, wanted.length, what);
  for (let i = 0; i < wanted.length; i++)
    assert.ok(Math.abs(found![i]! - wanted[i]!) <= within, `${what}: ${found![i]} is not ${wanted[i]}`);
}

const anyOf = ({ joints }: Chain, draw: ReturnType<typeof seededDraw>): number[] => joints.map(({ low, high }) => draw(low, high));

/** A planned motion ends at rest at its target, which is at the pose and inside the limits. */
function sound(planner: Planner, outcome: Outcome, pose: Float64Array | null, start: number[]): void {
  if (!outcome.ok) {
    assert.match(outcome.text, /^[a-z].*[a-z°]/);
    assert.ok(["range", "box", "busy"].includes(outcome.code));
    return;
  }
  assert.equal(planner.chain.brokenLimit(outcome.joints), "");
  if (pose) near(planner.chain.forward(outcome.joints), pose, 3e-6, "the tool's pose");
  near(outcome.path.sample(outcome.seconds), outcome.joints, 1e-9, "the end");
  near(outcome.path.sample(0), start, 0, "the start");
}

test("numbers in sentences are written as Python writes them", () => {
  for (const [value, ...wanted] of words)
    assert.deepEqual([fixed(value, 0), fixed(value, 1), fixed(value, 3), general(value, 3), general(value)], wanted, String(value));
  assert.deepEqual([fixed(NaN, 1), general(Infinity, 3), fixed(-Infinity, 0)], ["nan", "inf", "-inf"]);
});

for (const [name, { facts, cases }] of Object.entries(arms))
  test(`${name}: the same branch, path, distances and words as Python`, () => {
    const planner = new Planner(facts);
    assert.ok(cases.length >= 200);
    for (const one of cases) {
      const found = answers(planner, one),
        wanted = one.answers,
        what = JSON.stringify(one);
      assert.deepEqual([found.text, found.code], [wanted.text, wanted.code], what);
      assert.equal(found.reached === undefined, wanted.reached === undefined, what);
      if (wanted.reached) near(found.reached, wanted.reached, 1e-6, what);
      if (wanted.seconds !== undefined) near([found.seconds!], [wanted.seconds], 1e-6, what);
      if (wanted.tool) near(found.tool, wanted.tool, 1e-8, what);
      if (wanted.distances) near(found.distances, wanted.distances, 1e-6, what);
      if (wanted.third) near(found.third, wanted.third, 1e-6, what);
    }
  });

for (const [name, { facts, ready }] of Object.entries(arms)) {
  const planner = new Planner(facts),
    { chain } = planner;
  const at = (joints: number[]): Float64Array => chain.forward(joints);

  test(`${name}: what is no number, or far away, is refused`, () => {
    const pose = at(ready),
      told = (change: number, value: number): string => {
        const other = pose.slice();
        other[change] = value;
        const outcome = planner.plan({ pose: other }, { joints: ready });
        assert.equal(outcome.ok, false);
        return outcome.ok ? "" : outcome.text;
      };
    for (const place of [0, 3, 6, 11]) assert.match(told(place, NaN), /^that is .*: the arm reaches \d\.\d\d m at most$/);
    assert.match(told(3, Infinity), /^that is not a position/);
    assert.match(told(7, -1e200), /^that is 1e\+200 m from the base/);
    assert.match(told(0, pose[0]! + 0.01), /would remain|outside/); // no rotation
    assert.match(told(11, 1.9), /^the tool would remain 0\.\d{3} m away/);
    const short = planner.plan({ pose: [1, 0, 0] }, { joints: ready });
    assert.match(short.ok ? "" : short.text, /^that is not a position/);
    for (const joints of [[...ready.slice(0, 5), NaN], ready.slice(0, 5), []]) {
      const outcome = planner.plan({ pose }, { joints });
      assert.deepEqual(outcome, { ok: false, code: "busy", text: "the present joints are not known" });
      assert.equal(planner.plan({ pose }, { joints: ready, velocity: joints }).ok, false);
    }
    for (const value of [NaN, Infinity, -1e9, 7]) {
      const outcome = planner.plan({ joints: [...ready.slice(0, 5), value] }, { joints: ready });
      assert.match(outcome.ok ? "" : outcome.text, /^joint \w+ would be at (nan|inf|-5\.73e\+10|401\.1)°, outside /);
    }
    for (const scale of [0, 0.01, 1.1, NaN])
      assert.match(JSON.stringify(planner.plan({ joints: ready }, { joints: ready }, scale)), /must lie between 0.05 and 1"/);
  });

  test(`${name}: any numbers give a sound motion or a refusal`, () => {
    const draw = seededDraw(1);
    for (let n = 0; n < 80; n++) {
      const pose = Float64Array.from({ length: 16 }, () => draw(-1, 1) * 10 ** draw(-9, n % 2 ? 1 : 9)),
        joints = Array.from({ length: 6 }, () => draw(-1, 1) * 10 ** draw(-3, 3));
      sound(planner, planner.plan({ pose }, { joints: ready }), pose, ready);
      sound(planner, planner.plan({ joints }, { joints: ready, velocity: anyOf(chain, draw) }), null, ready);
      sound(planner, planner.plan({ pose: at(ready) }, { joints }), at(ready), joints);
    }
  });

  test(`${name}: a small step of the tool stays on the arm's branch`, () => {
    const draw = seededDraw(2);
    for (let n = 0; n < 2000; n++) {
      const start = chain.joints.map(({ low, high }) => draw(low + 0.01, high - 0.01));
      const target = start.map((value) => value + draw(-0.005, 0.005));
      const found = planner.reach(at(target), start);
      near(at(found), at(target), 2e-6, "the pose");
      const away = Math.max(...found.map((value, i) => Math.abs(value - start[i]!) / chain.joints[i]!.velocity));
      assert.ok(away < 0.051, `${start}: ${away} s away`); // at a singular pose, another answer may be as good
    }
  });

  test(`${name}: singular poses are reached from near by and from anywhere, and at once where the arm is`, () => {
    const draw = seededDraw(3);
    for (let n = 0; n < 300; n++) {
      const q = anyOf(chain, draw);
      if (n % 3) q[4] = 0;
      if (n % 3 === 2) q[2] = 0;
      const start = n % 2 ? anyOf(chain, draw) : q.map((value) => value + draw(-1e-3, 1e-3));
      near(planner.reach(at(q), q), q, 1e-5, "staying");
      const found = planner.reach(at(q), start);
      near(at(found), at(q), 3e-6, "the pose");
      assert.equal(chain.brokenLimit(found), "");
    }
    const zero = [0, 0, 0, 0, 0, 0];
    near(planner.reach(at(zero), zero), zero, 0, "upright");
  });
}

test("an arm of another shape is told apart when it is made", () => {
  const { facts } = arms["pa10"]!;
  const moved = structuredClone(facts) as { -readonly [K in keyof ArmFacts]: ArmFacts[K] };
  moved.joints = facts.joints.map((joint, n) => (n === 4 ? { ...joint, origin: joint.origin.map((v, k) => (k === 3 ? 0.05 : v)) } : joint));
  assert.throws(() => new Branches(new Chain(moved)), /no closed form is known/);
  moved.joints = facts.joints.slice(0, 5);
  assert.throws(() => new Branches(new Chain(moved)), /fewer than six axes/);
});
