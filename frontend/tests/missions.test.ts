/** Missions of the rover, read, written and judged as in Python (tests/unit/test_srv1_vectors.py). */
import assert from "node:assert/strict";
import { test } from "node:test";
import { ghostAt } from "../../robots/kit/drivers/srv1/console/mission_ghost.ts";
import { judge, type Judged, type Pose, remainder } from "../../robots/kit/drivers/srv1/console/mission_judge.ts";
import { parse, print } from "../../robots/kit/drivers/srv1/console/mission_text.ts";
import { vectorsOf } from "./helpers.ts";

interface Vectors {
  tables: Judged;
  missions: {
    text: string;
    here: Pose;
    written: string;
    legs: { step: number; end: number[]; corners: number; seconds: number; least: number }[];
    said: { step: number; at_s: number; text: string; refuses: boolean }[];
  }[];
  texts: { text: string; written?: string; refusal?: string }[];
}
const vectors = vectorsOf<Vectors>("missions");
const { hall } = vectors.tables;
const near = (found: number, wanted: number, what: string): void =>
  assert.ok(Math.abs(found - wanted) < 1e-5, `${what}: ${found}, not ${wanted}`);

test("a mission is judged alike", () => {
  for (const { text, here, written, legs, said } of vectors.missions) {
    const steps = parse(text, hall);
    assert.equal(print(steps), written);
    const found = judge(vectors.tables, steps, here);
    assert.equal(found.legs.length, legs.length, text);
    for (const [i, leg] of legs.entries()) {
      const mine = found.legs[i]!;
      assert.deepEqual([mine.step, mine.poses.length], [leg.step, leg.corners], text);
      near(mine.seconds, leg.seconds, `${text}, step ${leg.step}`);
      near(mine.least, leg.least, `${text}, step ${leg.step}`);
      const end = mine.poses.at(-1)!;
      for (const k of [0, 1]) near(end[k]!, leg.end[k]!, `${text}, step ${leg.step}`);
      near(Math.cos(end[2]), Math.cos(leg.end[2]!), `${text}, step ${leg.step}`);
    }
    const untimed = (all: typeof said): object[] => all.map(({ at_s: _, ...rest }) => rest);
    assert.deepEqual(untimed(found.said), untimed(said));
    for (const [i, one] of said.entries()) near(found.said[i]!.at_s, one.at_s, text);
  }
});

test("a text is read alike, or refused with the same sentence", () => {
  for (const { text, written, refusal } of vectors.texts) {
    const read = (): string => print(parse(text, hall));
    if (refusal === undefined) assert.equal(read(), written, JSON.stringify(text));
    else assert.throws(read, { message: refusal }, JSON.stringify(text));
  }
});

test("the ghost turns as the rover does, and drives where it looks", () => {
  const here: Pose = [1, 1, 2.5];
  const turns = { "turn 270": 270, "turn -360": -360, "turn 180": 180, "look around": 360, "turn 270\nwait 5\nturn 270": 540 };
  for (const [text, degrees] of Object.entries(turns)) {
    const { legs } = judge(vectors.tables, parse(text, hall), here),
      lasts = legs.reduce((sum, { seconds }) => sum + seconds, 0);
    let before = here,
      turned = 0;
    for (let n = 0; n <= 400; n++) {
      const at = ghostAt(vectors.tables, legs, (lasts * n) / 400.000001)!,
        step = remainder(at[2] - before[2]);
      assert.ok(step * degrees >= -1e-9 && Math.abs(step) < 0.3, `${text}: by ${step} at ${n}`);
      assert.deepEqual([at[0], at[1]], [1, 1]);
      turned += step;
      before = at;
    }
    near((turned * 180) / Math.PI, degrees, text);
    assert.equal(ghostAt(vectors.tables, legs, lasts), null);
  }
  for (const { text, here: begin } of vectors.missions) {
    const { legs } = judge(vectors.tables, parse(text, hall), begin);
    let before = begin,
      passed = 0;
    for (const { seconds, poses } of legs) {
      for (let at = 0; at < seconds - 0.01; at += 0.05) {
        const now = ghostAt(vectors.tables, legs, passed + at)!,
          [dx, dy] = [now[0] - before[0], now[1] - before[1]];
        const back = dx * Math.cos(now[2]) + dy * Math.sin(now[2]);
        assert.ok(Math.hypot(dx, dy) < 0.1, `${text}: it jumps to ${String(now)}`);
        assert.ok(back > -0.05, `${text}: it drives backwards at ${String(now)}`);
        before = now;
      }
      passed += seconds;
      if (seconds) for (const k of [0, 1]) assert.ok(Math.abs(before[k]! - poses.at(-1)![k]!) < 0.1, `${text}: the end of a step`);
    }
  }
});
