/** Missions of the rover, read, written and judged as in Python (tests/unit/test_srv1_vectors.py). */
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { judge, type Judged, type Pose } from "../../robots/drivers/srv1/console/mission_judge.ts";
import { parse, print } from "../../robots/drivers/srv1/console/mission_text.ts";

interface Vectors {
  tables: Judged;
  missions: {
    text: string; here: Pose; written: string;
    legs: { step: number; end: number[]; corners: number; seconds: number; least: number }[];
    said: { step: number; at_s: number; text: string; refuses: boolean }[];
  }[];
  texts: { text: string; written?: string; refusal?: string }[];
}
const vectors = JSON.parse(readFileSync(new URL("../../tests/vectors/missions.json", import.meta.url), "utf-8")) as Vectors;
const { hall } = vectors.tables;
const near = (found: number, wanted: number, what: string): void => assert.ok(Math.abs(found - wanted) < 1e-5, `${what}: ${found}, not ${wanted}`);

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
    assert.deepEqual(found.said.map(({ step, text: words, refuses }) => [step, words, refuses]), said.map(({ step, text: words, refuses }) => [step, words, refuses]));
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
