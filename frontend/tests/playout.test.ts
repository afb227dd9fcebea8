/** When pieces of sound are played. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { DELAY_S, MAX_DELAY_S, PlayoutBuffer } from "../src/media/playout.ts";

const SECONDS = 0.06;

/** A listener: what is left to be played, as times of begin, by number. */
class Listener {
  played = new Map<number, number>();
  private line = new PlayoutBuffer();

  take(number: number, now: number, run = 1): number | null {
    const { at, drop } = this.line.take({ run, number, seconds: SECONDS }, now);
    if (drop) for (const [other, begin] of this.played) if (begin > now) this.played.delete(other);
    if (at !== null) this.played.set(number, at);
    return at;
  }

  /** Nothing is played twice at once, or before it came. */
  sound(): number[] {
    const times = [...this.played.values()];
    times.slice(1).forEach((at, i) => assert.ok(at >= times[i]! + SECONDS - 1e-9, `${at} after ${times[i]}`));
    return times;
  }
}

test("pieces that come evenly, or a little unevenly, are played evenly, a little later", () => {
  const one = new Listener();
  for (let n = 0; n < 500; n++) one.take(n, 10 + n * SECONDS + (n % 5 === 0 ? 0.1 : 0) + (n % 3) * 0.01);
  const times = one.sound();
  assert.equal(times.length, 500);
  for (let n = 50; n < 500; n++) assert.ok(Math.abs(times[n]! - times[n - 1]! - SECONDS) < 1e-9);
});

test("after a pause what was missed is not played, and what comes then is of now", () => {
  const one = new Listener();
  for (let n = 0; n < 20; n++) one.take(n, n * SECONDS);
  const stalled = 20 * SECONDS + 2;
  for (let n = 20; n < 54; n++) one.take(n, stalled + n * 1e-4); // what waited on the way, at once
  for (let n = 54; n < 100; n++) one.take(n, n * SECONDS);
  const times = one.sound();
  for (let n = 60; n < 100; n++) assert.ok(one.played.get(n)! - n * SECONDS <= MAX_DELAY_S + 1e-9);
  assert.ok(times.length < 80, "a part was dropped");
});

test("a microphone whose clock is fast or slow is never farther and farther behind", () => {
  for (const drift of [0.999, 1.001]) {
    const one = new Listener();
    for (let n = 0; n < 10_000; n++) {
      const now = n * SECONDS * drift,
        at = one.take(n, now);
      assert.ok(at !== null && at >= now && at <= now + MAX_DELAY_S + 1e-9);
    }
    assert.ok(one.sound().length > 9900, "little is lost");
  }
});

test("what is missing stays silent, a late piece is left out, and a new run begins anew", () => {
  const one = new Listener();
  assert.equal(one.take(1, 0), DELAY_S);
  assert.equal(one.take(4, 3 * SECONDS), DELAY_S + 3 * SECONDS);
  assert.equal(one.take(3, 3 * SECONDS), null);
  assert.equal(one.take(4, 3 * SECONDS), null);
  assert.equal(one.take(1, 4 * SECONDS, 2), 4 * SECONDS + DELAY_S);
  assert.equal(one.played.has(4), false, "what waited is of the old run");
  assert.equal(one.take(0xffffffff, 10, 3), 10 + DELAY_S);
  assert.ok(one.take(0, 10 + SECONDS, 3) !== null, "the numbers begin anew");
});
