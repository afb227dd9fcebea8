/** What a line carries against what is asked for, and what a page makes of it. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { LineJudge, type Pace } from "../src/media/pace.ts";
import { type Carried, lineWords, ThroughputMeter, quality, isShort } from "../src/media/throughput.ts";

const BYTES: Record<Pace, number> = { live: 6000, coarse: 2000, stills: 6000, states: 0 }; // of a picture
const EVERY_MS: Record<Pace, number> = { live: 100, coarse: 200, stills: 5000, states: Infinity };
const MOST: Partial<Record<Pace, number>> = { coarse: 5 };

/**
 * Watch a camera of 10 pictures a second over a line that carries so many bytes a second and answers pings quickly: the
 * server sends the newest picture as soon as the one before is through. Returns the pace of each second, and the last
 * that was carried at each.
 */
function watch(bytesPerS: number, seconds: number): { paces: Pace[]; carried: Map<Pace, Carried> } {
  const judge = new LineJudge(0),
    meter = new ThroughputMeter(0),
    paces: Pace[] = [],
    carried = new Map<Pace, Carried>();
  let free = 0,
    next = 0,
    number = 0;
  for (let now = 0; now < seconds * 1000; now += 20) {
    if (now % 100 === 0) number += 1;
    if (now >= free && now >= next && judge.pace !== "states") {
      const size = BYTES[judge.pace];
      free = now + (size / bytesPerS) * 1000;
      next = now + EVERY_MS[judge.pace];
      meter.took(size, free);
      if (judge.pace === "live" || judge.pace === "coarse") meter.picture(0, number, size, free);
      judge.arrived(free - now);
    }
    if (now % 240 === 0) {
      const found = meter.carried(now, MOST[judge.pace]),
        before = judge.pace;
      carried.set(judge.pace, found);
      if (judge.judge(now, true, true, isShort(found))) meter.begin(now);
      if (judge.pace !== before) assert.notEqual(judge.pace, "states");
    }
    if (now % 1000 === 0) paces.push(judge.pace);
  }
  return { paces, carried };
}

test("an honest line keeps live pictures, and needs what arrives", () => {
  const { paces, carried } = watch(100_000, 600);
  assert.deepEqual(new Set(paces), new Set(["live"]));
  const { arrives, needs } = carried.get("live")!;
  assert.ok(Math.abs(arrives - 60_000) < 3000, `${arrives}`);
  assert.equal(needs, arrives);
});

test("a line that carries half of the pictures, each in time, gets coarse ones, all of them", () => {
  const { paces, carried } = watch(30_000, 3600);
  assert.ok(paces.indexOf("coarse") > 3 && paces.indexOf("coarse") <= 15, "soon, but not at the first gap");
  assert.ok(!paces.includes("stills"));
  assert.ok(isShort(carried.get("live")!));
  assert.ok(Math.abs(carried.get("live")!.needs - 60_000) < 6000, `${carried.get("live")!.needs}`);
  const coarse = carried.get("coarse")!;
  assert.ok(coarse.arrives >= 0.9 * coarse.needs, JSON.stringify(coarse));
  const tries = paces.filter((pace, i) => pace === "live" && paces[i - 1] === "coarse").length;
  assert.ok(tries >= 6 && tries <= 20, `live is tried ${tries} times in an hour`);
});

test("a line that carries a quarter of the coarse ones gets stills", () => {
  const { paces } = watch(2500, 600);
  assert.ok(paces.indexOf("stills") > 0 && paces.indexOf("stills") <= 30);
});

test("single gaps, another process's numbers and a pause are not a short line", () => {
  const meter = new ThroughputMeter(0);
  let number = 1000;
  for (let now = 100; now <= 4000; now += 100) {
    number += now % 1000 === 0 ? 2 : 1;
    meter.took(6000, now);
    meter.picture(0, number, 6000, now);
  }
  assert.ok(!isShort(meter.carried(4000)));
  for (const other of [3, 40_000]) meter.picture(0, other, 6000, 4000);
  assert.ok(!isShort(meter.carried(4000)));
  assert.ok(!isShort(new ThroughputMeter(0).carried(0)), "nothing came yet");
});

test("each camera has its own numbers, and what a word of the server takes is counted", () => {
  const meter = new ThroughputMeter(0);
  for (let now = 100; now <= 4000; now += 100) {
    meter.took(200, now);
    for (const camera of [0, 1]) meter.picture(camera, now / 100 + 500 * camera, 100, now);
  }
  const { arrives, needs } = meter.carried(4000);
  assert.equal(needs, arrives);
  assert.ok(Math.abs(arrives - 2000) < 100);
});

test("the line in words, with what comes of what is needed", () => {
  const all = { arrives: 61_200, needs: 61_200 },
    half = { arrives: 30_400, needs: 61_200 };
  assert.equal(lineWords(all, 40, 30), "Line good, 61 kB/s");
  assert.equal(lineWords(half, 40, 30), "Line poor, 30 of 61 kB/s");
  assert.equal(lineWords({ arrives: 1040, needs: 1040 }, 900, 60), "Line fair, 1.0 kB/s");
  assert.equal(quality(all, null, 30), "poor", "no answer");
  assert.equal(quality({ arrives: 45_000, needs: 61_200 }, 40, 30), "fair");
});
