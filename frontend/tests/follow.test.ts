/** The arm follows a hand: who holds it, what it is told, and each way in which the hand is lost. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { Follow } from "../src/input/follow.ts";
import { LONGEST_MS, Loop, TICK_MS } from "../src/input/loop.ts";
import { type Move, type Reading, type Source, STILL } from "../src/input/source.ts";
import { isLost, Steering } from "../src/input/steering.ts";
import { JUMP_M, JUMP_RAD } from "../src/input/clutch.ts";
import { seededDraw } from "./helpers.ts";

/** Sources, the loop that reads them and a command on a line that is written down, in virtual time. */
class Bench {
  now = 0;
  readings: (Reading | null)[] = [null, null];
  forgot = [0, 0];
  sent: [string, Record<string, number>?][] = [];
  said = "";
  at: number[] = [...STILL];
  whyNot = "";
  over = false; // at the server
  follow = new Follow(
    {
      whyNot: () => this.whyNot,
      begin: (args) => this.sent.push(["begin", args]),
      way: () => this.at as unknown as Move,
      over: (why) => {
        this.said = why;
        this.loop.drop();
        this.at = [...STILL];
      },
      keep: (_, args) => void this.sent.push(["keep", args]),
      release: () => void this.sent.push(["release"]),
      ended: () => this.over,
      refused: (why) => void (this.said = why),
    },
    () => this.now,
  );
  loop = new Loop(
    [0, 1].map((i): Source => ({ name: `${i}`, isRate: true, read: () => this.readings[i]!, forget: () => this.forget(i) })),
    {
      taken: () => undefined,
      released: () => undefined,
      moved: (_, by) => {
        if (this.follow.on && !this.follow.moved(by)) return;
        this.at = this.at.map((v, i) => v + by[i]!);
      },
      held: () => void (this.follow.begin() || this.loop.drop()),
      letGo: () => this.follow.end(),
      grip: (grip) => this.follow.grip(grip === "close" ? 1 : 0),
      stoodStill: (wasUsed) => wasUsed && (this.said = "stood still"),
    },
    () => this.now,
  );

  private forget(i: number): void {
    this.forgot[i]! += 1;
    this.readings[i] = null;
  }

  run(ms: number): void {
    for (let gone = 0; gone < ms; gone += TICK_MS) {
      this.now += TICK_MS;
      this.loop.tick();
      this.follow.tick();
    }
  }

  count(what: string): number {
    return this.sent.filter(([name]) => name === what).length;
  }

  get newest(): Record<string, number> {
    return this.sent.filter(([name, args]) => name === "keep" && args).at(-1)![1]!;
  }
}

const held = (by: Move = STILL, more: Partial<Reading> = {}): Reading => ({ by, clutch: true, grip: "", ...more });

test("it begins where the arm is, tells where the ghost is, and ends with the hand", () => {
  const bench = new Bench();
  bench.readings[0] = held([0.002, 0, 0, 0, 0, 0]);
  bench.run(1000);
  assert.deepEqual(bench.sent[0], ["begin", { dx: 0, dy: 0, dz: 0, rx: 0, ry: 0, rz: 0 }]);
  assert.ok(bench.count("keep") >= 11, "a keep-alive in 80 ms");
  assert.ok(Math.abs(bench.newest["dx"]! - 0.05) < 0.004);
  bench.readings[0] = null;
  bench.run(TICK_MS);
  assert.deepEqual(bench.sent.at(-1), ["release"]);
  bench.run(2000);
  assert.deepEqual([bench.count("begin"), bench.count("release"), bench.follow.on], [1, 1, false]);
  assert.equal("closed" in bench.newest, false, "a gripper that nobody has told anything stays as it is");
});

test("a ghost that rests is told seldom, though each keep-alive goes out", () => {
  const bench = new Bench();
  bench.readings[0] = held([0.01, 0, 0, 0, 0, 0]);
  bench.run(TICK_MS * 3);
  bench.readings[0] = held();
  bench.run(2000); // it has come to the ghost
  const before = bench.sent.length;
  bench.run(4000);
  const [all, told] = [bench.sent.slice(before), bench.sent.slice(before).filter(([, args]) => args)];
  assert.ok(all.length >= 45, `${all.length}`);
  assert.ok(told.length >= 8 && told.length <= 10, `${told.length}: one that was lost is told again`);
});

test("the pose is taken afresh when the hand holds again, and nothing is left of the time before", () => {
  const bench = new Bench();
  for (let n = 0; n < 50; n++) {
    bench.readings[0] = held([0.01, 0, 0, 0, 0, 0]);
    bench.run(400);
    bench.readings[0] = null;
    bench.run(80);
    const first = bench.sent.filter(([name]) => name === "begin").at(-1)![1]!;
    assert.ok(Object.values(first).every((v) => v === 0));
    bench.readings[0] = held();
    const before = bench.sent.length;
    bench.run(200);
    assert.ok(bench.sent.slice(before).every(([, args]) => !args || args["dx"] === 0), `${n}: it goes nowhere`); // prettier-ignore
    bench.readings[0] = null;
    bench.run(80);
  }
});

test("a page that stood still for a second lets go, and does nothing of what the hand did meanwhile", () => {
  const bench = new Bench();
  bench.readings[0] = held([0.002, 0, 0, 0, 0, 0]);
  bench.run(400);
  bench.now += LONGEST_MS + 1;
  const keeps = bench.count("keep");
  bench.readings[0] = held([0.09, 0, 0, 0, 0, 0]);
  bench.loop.tick();
  bench.follow.tick();
  assert.deepEqual(bench.sent.at(-1), ["release"]);
  assert.equal(bench.said, "stood still");
  assert.deepEqual(bench.at, [...STILL]);
  assert.ok(bench.forgot.every((times) => times > 0), "whatever is still pressed has to be released first"); // prettier-ignore
  bench.run(1000);
  assert.deepEqual([bench.count("keep"), bench.count("begin")], [keeps, 1]);
});

test("a jump of 0.1 m, or of a great angle, loses the hand", () => {
  for (const by of [
    [JUMP_M + 1e-4, 0, 0, 0, 0, 0],
    [0, 0, 0, 0, 0, JUMP_RAD + 1e-4],
    [NaN, 0, 0, 0, 0, 0],
  ] as unknown as Move[]) {
    // prettier-ignore
    const bench = new Bench();
    bench.readings[0] = held();
    bench.run(200);
    bench.readings[0] = held(by);
    bench.run(TICK_MS);
    assert.deepEqual(bench.sent.at(-1), ["release"]);
    assert.match(bench.said, /jumped/);
    assert.deepEqual(bench.at, [...STILL], "the ghost does not jump either");
    bench.run(500);
    assert.equal(bench.count("begin"), 1, "it has to be taken again");
  }
  assert.equal(isLost([JUMP_M * 0.9, 0, 0, 0, 0, 0]), false);
});

test("only the control that began it goes on with it; another one may move the ghost", () => {
  const bench = new Bench();
  bench.readings = [held(), { by: [0, 0.003, 0, 0, 0, 0], clutch: false, grip: "" }];
  bench.run(400);
  assert.ok(bench.newest["dy"]! > 0.01);
  bench.readings = [null, held()];
  bench.run(TICK_MS);
  assert.deepEqual(bench.sent.at(-1), ["release"], "another control that is pressed meanwhile takes over nothing");
  assert.equal(bench.readings[1], null);
});

test("where it may not begin it says why, and every hand has to let go", () => {
  const bench = new Bench();
  bench.whyNot = "Stopped.";
  bench.readings[0] = held();
  bench.run(400);
  assert.deepEqual([bench.sent, bench.said, bench.forgot[0]! > 0], [[], "Stopped.", true]);
});

test("what has ended at the server ends here, and nothing begins by itself", () => {
  const bench = new Bench();
  bench.readings[0] = held();
  bench.run(200);
  bench.over = true;
  bench.run(TICK_MS);
  assert.equal(bench.follow.on, false);
  bench.run(1000);
  assert.equal(bench.count("begin"), 1);
});

test("the gripper moves only while the arm's control is held, and by a press that was made meanwhile", () => {
  const bench = new Bench();
  bench.readings[0] = held(STILL, { grip: "close" });
  bench.run(400);
  assert.equal("closed" in bench.newest, false, "it was pressed before the hand took the ghost");
  bench.readings[0] = held();
  bench.run(TICK_MS);
  bench.readings[0] = held(STILL, { grip: "close" });
  bench.run(200);
  assert.equal(bench.newest["closed"], 1);
  bench.readings[1] = { by: STILL, clutch: false, grip: "" };
  bench.run(TICK_MS);
  bench.readings[1] = { by: STILL, clutch: false, grip: "open" };
  bench.run(200);
  assert.equal(bench.newest["closed"], 1, "another device's button does not count");
  bench.readings = [null, null];
  bench.run(200);
  const sent = bench.sent.length;
  bench.readings[0] = { by: STILL, clutch: false, grip: "" };
  bench.run(TICK_MS);
  bench.readings[0] = { by: STILL, clutch: false, grip: "open" };
  bench.run(400);
  assert.equal(bench.sent.length, sent, "nothing is sent while the arm's control is not held");
});

test("what the arm is told approaches the ghost, and never jumps, however late a keep-alive is", () => {
  const draw = seededDraw(5),
    steering = new Steering();
  let before = steering.next(STILL, 0),
    wanted = [...STILL];
  for (let n = 0; n < 5000; n++) {
    if (n % 40 === 0) wanted = wanted.map((_, i) => draw(-1, 1) * (i < 3 ? 1.5 : 2.5));
    let now = before;
    for (let lost = 0; lost < 3; lost++) now = steering.next(wanted as unknown as Move, draw(0, 0.1)); // 0.25 s without one ends it
    const [x, y, z] = ["dx", "dy", "dz"].map((name) => now[name]! - before[name]!);
    assert.ok(Math.hypot(x!, y!, z!) < JUMP_M, `${n}`);
    assert.ok(Math.hypot(now["dx"]!, now["dy"]!, now["dz"]!) <= 1.0001, "its argument reaches so far");
    before = now;
  }
  for (let n = 0; n < 200; n++) before = steering.next([0.2, -0.1, 0.05, 0, 0, 0.4], 0.08);
  assert.deepEqual(before, { dx: 0.2, dy: -0.1, dz: 0.05, rx: 0, ry: 0, rz: 0.4 });
});
