/** Places on a plane, their letters, the frame of a map, and waits in words. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { fittingBox, landmarks, nearest, Scale, whereabouts } from "../src/widgets/plane.ts";
import { jobSentence, waitWords } from "../src/queue/waits.ts";

const row = (count: number, step = 0.05): Map<number, { x: number; y: number }> =>
  new Map(Array.from({ length: count }, (_, i) => [i, { x: i * step, y: 0 }]));

const points = (...at: [x: number, y: number][]): { x: number; y: number }[] => at.map(([x, y]) => ({ x, y }));

test("what is drawn somewhere is found there again", () => {
  const scale = new Scale(fittingBox(null, points([-1, 2], [1, 0.5])), 320, 290);
  for (const { x, y } of points([-1, 2], [0.3, 0.7], [1, 0.5])) {
    const [u, v] = scale.toScreen(x, y);
    assert.ok(u > 0 && u < 320 && v > 0 && v < 290, `${u}, ${v}`);
    const [back, up] = scale.toPlane(u, v);
    assert.ok(Math.hypot(back - x, up - y) < 1e-9);
  }
});

test("the frame stays while the map fills it, grows with it, and follows a map that pulls together", () => {
  const frame = fittingBox(null, points([0, 0], [2, 2]))!;
  assert.equal(fittingBox(frame, points([0.1, 0], [1.9, 2])), frame);
  assert.ok(fittingBox(frame, points([0, 0], [3, 2]))!.right > 3);
  assert.ok(fittingBox(frame, points([0, 0], [1, 1]))!.right < 1.2);
  assert.equal(fittingBox(null, []), null);
  assert.ok(Number.isFinite(new Scale(null, 1, 1).pixels), "a canvas without a size");
});

test("the nearest place, and none far away", () => {
  assert.equal(nearest(row(10), 0.11, 0.02, 0.1), 2);
  assert.equal(nearest(row(10), 0.11, 0.5, 0.1), null);
  assert.equal(nearest(new Map(), 0, 0, 1), null);
  assert.equal(nearest(row(10), NaN, 0, 1), null);
});

test("letters stand apart, stay with their places, and are free again when a place is gone", () => {
  const first = landmarks(new Map(), row(20));
  assert.deepEqual([...first.keys()], ["A", "B", "C"]);
  const grown = landmarks(first, row(40));
  for (const [letter, id] of first) assert.equal(grown.get(letter), id);
  const fewer = row(40);
  fewer.delete(grown.get("A")!);
  const next = landmarks(grown, fewer);
  assert.equal(next.get("B"), grown.get("B"));
  assert.notEqual(next.get("A"), grown.get("A"));
  assert.equal(landmarks(new Map(), row(5000)).size, 26, "not more than the alphabet has");
});

test("where a place is", () => {
  const square = new Map(points([0, 0], [2, 2]).entries());
  assert.equal(whereabouts({ x: 0, y: 2 }, square), "top left");
  assert.equal(whereabouts({ x: 1, y: 1 }, square), "centre");
  assert.equal(whereabouts({ x: 1, y: 0 }, square), "bottom");
});

test("waits in words", () => {
  assert.equal(waitWords(null), "the wait is not known now");
  assert.equal(waitWords([0, 5]), "any moment now");
  assert.equal(waitWords([0, 600]), "at most 10 min");
  assert.equal(waitWords([21, 38]), "less than a minute");
  assert.equal(waitWords([61, 600]), "about 2 min to 10 min");
});

test("a job that waits says how many are before it, or that staff have to resume", () => {
  assert.equal(jobSentence("goal", 0, [0, 5], false), "Your goal waits. It is next; any moment now.");
  assert.equal(jobSentence("goal", 1, [0, 60], false), "Your goal waits. One is before it; at most 1 min.");
  assert.equal(jobSentence("goal", 3, null, false), "Your goal waits. 3 are before it; the wait is not known now.");
  const suspended = jobSentence("goal", 0, null, true);
  assert.match(suspended, /keeps its place.*until staff press Resume jobs/);
  assert.doesNotMatch(suspended, /next/);
});
