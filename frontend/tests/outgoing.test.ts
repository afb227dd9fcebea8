/** The messages of a page over a thin line that is simulated: a stop overtakes all, and what is held says if it comes too late. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { stub } from "./helpers.ts";

let now = 0; // ms
stub({ performance: { now: () => now } });
const { Outgoing } = await import("../src/socket/outgoing.ts");
const { TEXT_PIECE, TextPieces } = await import("../src/socket/pieces.ts");
const { HeldMotion, SILENT_MS, TOO_SLOW } = await import("../src/socket/held_motion.ts");

const HEAD = 6,
  DELAY_MS = 150,
  STEP_MS = 5;

/** A line of so many bytes a second, each way as late as the other; the portal answers pings at once. */
class Line {
  heard: { at: number; text: string }[] = [];
  thin = true;
  rate: number; // bytes/s
  readonly outgoing = new Outgoing({
    write: (data) => this.write(data),
    ping: () => this.ping(),
    best: () => 2 * DELAY_MS + 100, // at best this line answered a little later
    thin: () => this.thin,
  });
  private onTheWay: { left: number; text: string }[] = [];
  private coming: { at: number; text: string }[] = [];
  private answers: { at: number; n: number }[] = [];
  private pings = 0;

  constructor(rate: number) {
    this.rate = rate;
  }

  send(message: { t: string; seq?: number; n?: number; words?: string; args?: object }): void {
    this.outgoing.send(message, JSON.stringify(message));
  }

  private write(data: string | Uint8Array): void {
    this.onTheWay.push({ left: HEAD + data.length, text: typeof data === "string" ? data : `ping ${data[2]}` });
  }

  private ping(): number {
    this.outgoing.send({ t: "ping" }, Uint8Array.of(11, 0, (this.pings = (this.pings + 1) % 256)));
    return this.pings;
  }

  get bytes(): number {
    return this.onTheWay.reduce((sum, one) => sum + one.left, 0);
  }

  pass(ms: number, each: () => void = () => undefined): void {
    for (let left = ms; left > 0; left -= STEP_MS) {
      now += STEP_MS;
      each();
      for (let credit = (this.rate * STEP_MS) / 1000; credit > 0 && this.onTheWay[0];) {
        const first = this.onTheWay[0],
          taken = Math.min(credit, first.left);
        first.left -= taken;
        credit -= taken;
        if (first.left <= 1e-9) this.coming.push({ at: now + DELAY_MS, text: this.onTheWay.shift()!.text });
      }
      while (this.coming[0] && this.coming[0].at <= now) this.arrive(this.coming.shift()!.text);
      while (this.answers[0] && this.answers[0].at <= now) this.outgoing.answered(this.answers.shift()!.n);
    }
  }

  private arrive(text: string): void {
    if (text.startsWith("ping ")) this.answers.push({ at: now + DELAY_MS, n: Number(text.slice(5)) });
    else this.heard.push({ at: now, text });
  }

  /** The messages that have come, whole. */
  get whole(): string[] {
    const texts = new TextPieces();
    return this.heard
      .map(({ text }) => (text.startsWith(TEXT_PIECE) ? texts.take(text) : text))
      .filter((text) => text !== null && !text.includes('"stop"')) as string[];
  }
}

const program = { t: "command", seq: 1, words: "move 😀 ".repeat(1000) };

for (const [rate, mostMs] of [
  [100, 1000],
  [500, 800],
  [1000, 800],
] as const)
  test(`at ${rate} bytes/s a stop overtakes a program of 8 kB and the keep-alives behind it`, () => {
    const line = new Line(rate);
    line.send(program);
    line.send({ t: "command", seq: 2 });
    line.pass(12_000);
    const pressed = now;
    line.send({ t: "stop" });
    line.pass(5000);
    const stop = line.heard.find(({ text }) => text.includes('"stop"'));
    assert.ok(stop, "it has come");
    assert.ok(stop.at - pressed <= mostMs, `after ${stop.at - pressed} ms`);
    if (rate === 100) assert.equal(line.whole.length, 0, "the program is still on its way");
    line.pass(300_000);
    assert.deepEqual(
      line.whole,
      [program, { t: "command", seq: 2 }].map((one) => JSON.stringify(one)),
      "the others in their order",
    );
  });

test("a line is used: most of what it carries is the message", () => {
  const line = new Line(1000);
  line.send(program);
  const begun = now;
  line.pass(60_000);
  const took = line.heard.at(-1)!.at - begun;
  assert.ok(took < 1.5 * JSON.stringify(program).length + 1000, `${took} ms`);
});

test("over a line that is not thin everything is written at once", () => {
  const line = new Line(100);
  line.thin = false;
  line.send(program);
  line.send({ t: "keep", seq: 1 });
  line.pass(STEP_MS);
  assert.ok(line.bytes > 8000);
});

test("a line that becomes thin, or was stopped often, carries what is sent after that", () => {
  const line = new Line(1000);
  line.thin = false;
  line.send(program);
  line.thin = true;
  for (let n = 0; n < 20; n += 1) line.send({ t: "stop" });
  line.send({ t: "command", seq: 2 });
  line.pass(20_000);
  assert.deepEqual(line.whole.at(-1), '{"t":"command","seq":2}');
});

test("a wish for less is sent at once though no answer comes", () => {
  const line = new Line(0);
  line.send(program);
  const before = line.bytes;
  line.send({ t: "watch" });
  assert.equal(line.bytes - before, HEAD + '{"t":"watch"}'.length);
});

test("of keep-alives that cannot be sent the newest alone waits, and a release takes its place", () => {
  const line = new Line(0);
  for (let n = 0; n < 100; n += 1) line.send({ t: "keep", seq: 4, args: { x: n } });
  assert.ok(line.bytes < 400);
  line.send({ t: "released", seq: 4 });
  line.rate = 100;
  line.pass(10_000);
  const last = line.heard.at(-1)!.text;
  assert.equal(last, '{"t":"released","seq":4}');
  assert.ok(line.heard.length < 12);
});

test("another socket begins empty", () => {
  const line = new Line(0);
  line.send(program);
  line.outgoing.clear();
  assert.equal(line.outgoing.lateMs, 0);
  line.rate = 1000;
  line.pass(60_000);
  assert.equal(line.whole.length, 0);
});

function held(line: Line, said: string[]): InstanceType<typeof HeldMotion> {
  return new HeldMotion({
    send: (message) => line.send(message as { t: string; seq: number }),
    ended: () => false,
    refused: (why) => void said.push(why()),
    late: () => line.outgoing.lateMs > SILENT_MS,
  });
}

test("what is held says that the line is too slow as soon as the robot would rest, and not before", () => {
  const said: string[] = [],
    line = new Line(1000),
    motion = held(line, said);
  motion.hold(1, "jog");
  assert.deepEqual([motion.kindOf(1), motion.kindOf(2)], ["jog", ""]);
  let kept = 0;
  const hold = (): void => {
    if (now - kept < 80) return;
    kept = now;
    motion.keep(1);
  };
  line.pass(20_000, hold);
  assert.deepEqual(said, []);
  const gaps = line.heard.slice(1).map(({ at }, i) => at - line.heard[i]!.at);
  assert.ok(Math.max(...gaps) <= SILENT_MS, `keep-alives come each ${Math.max(...gaps)} ms`);
  line.rate = 0;
  const stalled = now;
  let first = 0;
  line.pass(5000, () => {
    hold();
    if (said.length && !first) first = now;
  });
  assert.ok(first && first - stalled < 1200, `said after ${first - stalled} ms`);
  assert.equal(said[0], TOO_SLOW);
  assert.ok(line.bytes < 500, "little will arrive late");
});
