import assert from "node:assert/strict";
import { test } from "node:test";
import { buzz, EVERY_MS, force, rumble } from "../../robots/kit/drivers/srv1/console/force.ts";
import { added, inWords, KEPT_MS, line, type Sample, STEP_MS } from "../../robots/kit/drivers/srv1/console/history.ts";

const RANGES = { infrared: { stop: 0.15, far: 0.8 }, sonar: { stop: 0.2 } };
const f = (infrared?: number, sonar?: number, ahead = 1): number => force(infrared, sonar, ahead, RANGES);

test("nothing near, nothing known, or driving back: no force", () => {
  for (const level of [f(0.8, 10), f(), f(NaN, NaN), f(0.1, 0.1, 0), f(0.1, 0.1, -1), f(0.1, 0.1, NaN)]) assert.equal(level, 0);
  assert.equal(force(0.3, undefined, 1, { ...RANGES, infrared: { stop: 1, far: 0.5 } }), 0, "a description upside down");
});

test("the nearer, the more, up to all at the reflex; sonar alone is never all", () => {
  let before = 0;
  for (let metres = 0.8; metres > 0; metres -= 0.01) {
    const level = f(metres, 10);
    assert.ok(level >= before && level <= 1);
    before = level;
  }
  assert.equal(f(0.15, 10), 1);
  assert.equal(f(-5, 10), 1);
  assert.equal(f(0.2, 10), 1, "the sonar's reflex stops it there, before that of infrared");
  assert.ok(f(0.8, 0.1) > 0.3 && f(0.8, 0.1) < 1);
  assert.ok(f(0.8, 1) < f(0.8, 0.5));
});

test("what is felt is bounded, and too little is not felt", () => {
  assert.equal(rumble(0.01), null);
  assert.equal(buzz(0.01), 0);
  for (const level of [0.1, 0.5, 1, 7]) {
    const { strongMagnitude, weakMagnitude } = rumble(level)!;
    assert.ok(strongMagnitude <= 1 && weakMagnitude <= 1 && strongMagnitude > 0);
    assert.ok(buzz(level) < EVERY_MS);
  }
  assert.ok(buzz(1) > buzz(0.2));
});

const samples = (...all: [at: number, value: number][]): Sample[] => all.map(([at, value]) => ({ at, value }));

test("a sample in two seconds, of five minutes", () => {
  let kept: readonly Sample[] = [];
  for (let at = 0; at <= 2 * KEPT_MS; at += 100) kept = added(kept, at, Math.sin(at));
  assert.ok(kept.length <= KEPT_MS / STEP_MS + 1);
  assert.ok(kept.at(-1)!.at - kept[0]!.at <= KEPT_MS);
  for (const bad of [undefined, NaN, Infinity]) assert.equal(added(kept, 9e9, bad), kept);
  assert.equal(added(kept, 5, 1).length, 1, "a recording was set back");
});

test("the line lies in its picture, and a value that hardly changes in its middle", () => {
  const points = (...all: [number, number][]): number[][] => {
    const drawn = line(samples(...all), 100_000, 1).split(" ");
    return drawn.map((one) => one.split(",").map(Number));
  };
  assert.equal(line([], 0, 1), "");
  assert.deepEqual(points([100_000, 8.2]), [[100, 10]]);
  for (const [x, y] of points([0, 1e6], [50_000, -1e6], [100_000, 3])) assert.ok(x! >= 0 && x! <= 100 && y! >= 0 && y! <= 20);
  for (const [, y] of points([0, 8.2], [1, 8.21])) assert.ok(Math.abs(y! - 10) < 0.2);
});

test("and it says the same in words", () => {
  const volts = (v: number): string => `${v.toFixed(1)} V`;
  assert.equal(inWords("Battery", [], volts), "Battery: not known yet");
  assert.equal(inWords("Battery", samples([0, 8], [20_000, 8]), volts), "Battery: 8.0 V in the last minute");
  const falling = inWords("Battery", samples([0, 8], [240_000, 7]), volts);
  assert.equal(falling, "Battery: from 7.0 V to 8.0 V in the last 4 minutes, now 7.0 V");
});
