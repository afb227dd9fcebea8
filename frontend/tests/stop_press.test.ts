import assert from "node:assert/strict";
import { test } from "node:test";
import { bannerWords, unconfirmedStop, type BannerFacts } from "../src/page/banner.ts";
import type { Snapshot } from "../src/socket/messages.ts";
import { StopPress, UNSENT } from "../src/page/stop_press.ts";

const snapshot = (grant: number | null, may_stop = true): Snapshot =>
  ({ turn: grant === null ? null : { grant }, me: { can: { drive: may_stop, stop: may_stop } }, link: true }) as unknown as Snapshot;

class Line {
  lost = false;
  opened = 1;
  sent = 0;
  send = (): boolean => {
    if (this.lost) return false;
    this.sent += 1;
    return true;
  };
}

function pressed(): { line: Line; stop: StopPress; said: string[] } {
  const line = new Line(),
    said: string[] = [];
  const stop = new StopPress(line, (words) => said.push(words));
  stop.update(snapshot(7));
  line.lost = true;
  stop.press();
  return { line, stop, said };
}

function back(line: Line): void {
  line.lost = false;
  line.opened += 1;
}

test("a Stop that cannot be sent says so until it is", () => {
  const { line, stop } = pressed();
  assert.equal(stop.pending, UNSENT);
  assert.equal(line.sent, 0);
  back(line);
  stop.update(snapshot(7));
  assert.equal(line.sent, 1);
  stop.update(snapshot(7));
  assert.equal(line.sent, 1, "sent once on a line");
  stop.answer(true);
  assert.equal(stop.pending, "");
});

test("a late Stop goes only into the turn that it was meant for", () => {
  for (const now of [snapshot(8), snapshot(null), snapshot(7, false)]) {
    const { line, stop, said } = pressed();
    back(line);
    stop.update(now);
    assert.equal(line.sent, 0);
    assert.match(said[0] ?? "", /was not sent/);
    assert.equal(stop.pending, "");
  }
});

test("a Stop that is answered at once says nothing more", () => {
  const line = new Line(),
    said: string[] = [];
  const stop = new StopPress(line, (words) => said.push(words));
  stop.update(snapshot(7));
  stop.press();
  assert.equal(stop.pending, "");
  assert.equal(stop.answer(true), false);
  assert.deepEqual(said, []);
});

test("a late Stop that went into two sockets before it was answered is told once", (context) => {
  let clock = 1000;
  context.mock.method(performance, "now", () => clock);
  const { line, stop, said } = pressed();
  clock += 5000;
  back(line);
  stop.update(snapshot(7));
  line.opened += 1; // the operator's own stream takes over
  stop.update(snapshot(7));
  assert.equal(line.sent, 2);
  assert.deepEqual([stop.answer(true), stop.answer(true), stop.answer(true)], [true, true, false]);
  assert.equal(said.length, 1);
  assert.match(said[0] ?? "", /has been sent now/);
});

const known = (more: Partial<BannerFacts>): BannerFacts => ({
  lost: false,
  lostMs: 0,
  offline: false,
  robotSilent: false,
  stopPending: "",
  storeDown: "",
  snapshot: snapshot(7),
  now: 100_000,
  ...more,
});

test("a lost connection never blames the robot, for as long as it lasts", () => {
  for (const lostMs of [1001, 5000, 60_000, 3_600_000])
    for (const offline of [true, false]) {
      const words = bannerWords(known({ lost: true, lostMs, offline, robotSilent: true, storeDown: "The database is away." }));
      assert.match(words, /^Connection lost/);
      assert.doesNotMatch(words, /robot does not answer|database/);
    }
  assert.equal(bannerWords(known({ lost: true, lostMs: 500, robotSilent: true })), "");
  assert.match(bannerWords(known({ robotSilent: true })), /robot does not answer/);
  assert.match(bannerWords(known({ lost: true, lostMs: 100, stopPending: UNSENT })), /could not be sent/);
});

test("a stop that the robot has not confirmed says so, with the latest time by which it rests", () => {
  const stop = (confirmed: boolean, rests_by_ms: number | null) => ({ confirmed, since_ms: 90_000, rests_by_ms });
  assert.equal(unconfirmedStop(null, 100_000), "");
  assert.equal(unconfirmedStop(stop(true, null), 100_000), "");
  assert.equal(unconfirmedStop(stop(false, null), 90_500), "", "a moment is no news");
  assert.match(unconfirmedStop(stop(false, null), 91_500), /not confirmed .* not known/);
  assert.match(unconfirmedStop(stop(false, 112_000), 100_000), /not confirmed .* at \d\d:\d\d:\d\d at the latest/);
  assert.match(unconfirmedStop(stop(false, 99_000), 100_000), /should rest since/);
  const shown = { ...snapshot(7), stop: stop(false, 112_000) } as Snapshot;
  assert.match(bannerWords(known({ snapshot: shown, robotSilent: true })), /has not confirmed/);
});
