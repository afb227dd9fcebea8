/** How much a page asks for, by what its line can carry. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { LineJudge, type Pace, isQuick } from "../src/media/pace.ts";

const STEP_MS = 250;

interface Slowness {
  age: (pace: Pace) => number | null;
  latency: (pace: Pace) => number | null;
}

/** Let pictures arrive at the present pace with these ages, and pings be answered so; returns the paces of each second. */
function run(judge: LineJudge, from: number, seconds: number, line: Slowness): Pace[] {
  const seen: Pace[] = [];
  let next = from;
  for (let now = from; now < from + seconds * 1000; now += STEP_MS + (now % 7)) {
    const age = line.age(judge.pace);
    if (age !== null && now >= next && judge.pace !== "states") {
      judge.arrived(age);
      next = now + (judge.pace === "stills" ? 5000 : 100);
    }
    judge.judge(now, true, isQuick(line.latency(judge.pace), 50));
    while (seen.length <= (now - from) / 1000) seen.push(judge.pace);
  }
  return seen;
}

const GOOD = { age: () => 200, latency: () => 50 };
/** A line that carries stills, but not live pictures. */
const NARROW = {
  age: (pace: Pace) => (pace === "stills" ? 800 : 9000),
  latency: (pace: Pace) => (pace === "live" || pace === "coarse" ? 5000 : 300),
};
/** A line that carries coarse pictures, but not whole ones. */
const MIDDLE = { age: (pace: Pace) => (pace === "live" ? 9000 : 500), latency: (pace: Pace) => (pace === "live" ? 5000 : 300) };

test("a good line stays live, also while the robot's camera sends nothing or its clock is behind", () => {
  assert.deepEqual(new Set(run(new LineJudge(0), 0, 600, GOOD)), new Set(["live"]));
  assert.deepEqual(new Set(run(new LineJudge(0), 0, 600, { ...GOOD, age: () => null })), new Set(["live"]));
  assert.deepEqual(new Set(run(new LineJudge(0), 0, 600, { ...GOOD, age: () => 60_000 })), new Set(["live"]));
});

test("a line on which live pictures grow old gets one now and then, and more is tried less and less often", () => {
  const seen = run(new LineJudge(0), 0, 7200, NARROW);
  assert.ok(seen.indexOf("stills") <= 11, "soon");
  assert.ok(!seen.includes("states"));
  const tries = seen.flatMap((pace, i) => (pace === "coarse" && seen[i - 1] === "stills" ? [i] : []));
  assert.ok(tries.length >= 10 && tries.length <= 30, `${tries.length} tries in two hours`);
  const rare = tries.slice(-5).every((at, i, last) => i === 0 || at - last[i - 1]! > 300);
  assert.ok(rare, "no more often than every five minutes at last");
});

test("a line that carries coarse pictures gets those, and whole ones are tried less and less often", () => {
  const seen = run(new LineJudge(0), 0, 3600, MIDDLE);
  assert.ok(seen.indexOf("coarse") <= 6, "soon");
  assert.ok(!seen.includes("stills"));
  const tries = seen.filter((pace, i) => pace === "live" && seen[i - 1] === "coarse").length;
  assert.ok(tries >= 6 && tries <= 20, `${tries} tries in an hour`);
});

test("a line that carries no picture in time gets states only", () => {
  const seen = run(new LineJudge(0), 0, 300, { age: () => 20_000, latency: () => 5000 });
  assert.equal(seen.at(-1), "states");
  assert.ok(seen.indexOf("states") <= 40);
});

test("when the line is good again, pictures come back, live at last, or as far as the person's browser wants", () => {
  for (const top of ["live", "stills"] as const) {
    const judge = new LineJudge(0, top);
    run(judge, 0, 100, { age: () => 20_000, latency: () => null });
    assert.equal(judge.pace, "states");
    assert.equal(run(judge, 100_000, 400, GOOD).at(-1), top);
  }
});

test("an answer is quick by the line's own best, within limits", () => {
  assert.ok(isQuick(690, 20) && !isQuick(800, 20), "an ordinary line");
  assert.ok(isQuick(900, 600) && !isQuick(1400, 600), "by satellite");
  assert.ok(!isQuick(1600, 3000), "a line that was never quick");
  assert.ok(!isQuick(null, 20), "no answer");
});

test("a line whose pictures come late is not asked for more, however quickly it answers", () => {
  const judge = new LineJudge(0);
  for (const pace of ["coarse", "stills"]) {
    judge.down(0);
    assert.equal(judge.pace, pace);
  }
  for (let now = 0; now < 600_000; now += 250) {
    if (now % 8000 === 0) judge.arrived(8000);
    judge.judge(now, true, true);
  }
  assert.equal(judge.pace, "stills");
  judge.arrived(2000);
  judge.judge(600_000, true, true);
  assert.equal(judge.pace, "coarse", "once one has come in time it is tried");
});
