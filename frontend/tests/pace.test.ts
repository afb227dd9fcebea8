/** How much a page asks for, by what its line can carry. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { LineJudge, type Pace } from "../src/pace.ts";

const STEP_MS = 250;

/** Let pictures arrive at the present pace with these ages; returns the paces of each second. */
function run(judge: LineJudge, from: number, seconds: number, line: { age: (pace: Pace) => number | null; latency: number | null }): Pace[] {
  const seen: Pace[] = [];
  let next = from;
  for (let now = from; now < from + seconds * 1000; now += STEP_MS) {
    const age = line.age(judge.pace);
    if (age !== null && now >= next && judge.pace !== "states") {
      judge.arrived(age);
      next = now + (judge.pace === "stills" ? 5000 : 100);
    }
    judge.judge(now, true, line.latency);
    if ((now - from) % 1000 === 0) seen.push(judge.pace);
  }
  return seen;
}

test("a good line stays live, also while the robot's camera sends nothing", () => {
  assert.deepEqual(new Set(run(new LineJudge(0), 0, 600, { age: () => 200, latency: 50 })), new Set(["live"]));
  assert.deepEqual(new Set(run(new LineJudge(0), 0, 600, { age: () => null, latency: 50 })), new Set(["live"]));
});

test("a line on which live pictures grow old gets one now and then, and more is tried less and less often", () => {
  const seen = run(new LineJudge(0), 0, 1800, { age: (pace) => (pace === "live" ? 9000 : 800), latency: 300 });
  assert.ok(seen.indexOf("stills") <= 6, "soon");
  assert.ok(!seen.includes("states"));
  const tries = seen.filter((pace, i) => pace === "live" && seen[i - 1] === "stills").length;
  assert.ok(tries >= 3 && tries <= 9, `${tries} tries in half an hour`);
});

test("a line that carries no picture in time gets states only", () => {
  const seen = run(new LineJudge(0), 0, 300, { age: () => 20_000, latency: 5000 });
  assert.equal(seen.at(-1), "states");
  assert.ok(seen.indexOf("states") <= 40);
});

test("when the line is good again, pictures come back, live at last", () => {
  const judge = new LineJudge(0);
  run(judge, 0, 100, { age: () => 20_000, latency: null });
  assert.equal(judge.pace, "states");
  assert.equal(run(judge, 100_000, 400, { age: () => 150, latency: 40 }).at(-1), "live");
});
