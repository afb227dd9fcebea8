/** Where the robot goes, for who watches: the newest command that runs, the drawn end of an arm's motion, Mercury's cross. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { type Map2, pixel, target } from "../../robots/kit/drivers/mercury/console/scara.ts";
import { targetOf } from "../src/page/target.ts";
import { Story } from "../src/replay/story.ts";
import { WatchedGoal } from "../src/scene/watched_goal.ts";
import type { CommandInfo, Target } from "../src/socket/messages.ts";
import type { PathPacket } from "../src/socket/packets.ts";
import { FINAL } from "../src/socket/stages.ts";
import { seededDraw } from "./helpers.ts";

const told = (id: number, state: string, more: Partial<CommandInfo> = {}): CommandInfo => ({
  id, seq: id, grant: 3, kind: "move", state, reason: "", at_ms: 0, target: { words: `Move ${id}`, place: { x: 0.1, y: 0.4 } }, ...more,
}); // prettier-ignore

test("of the commands that run the newest one counts, and none that has ended, or that has no target", () => {
  assert.equal(targetOf([]), null);
  assert.deepEqual(targetOf([told(7, "sent")]), { id: 7, words: "Move 7", place: { x: 0.1, y: 0.4 } });
  assert.equal(targetOf([told(7, "sent"), told(9, "acknowledged"), told(8, "sent")])?.id, 9);
  for (const state of FINAL) assert.equal(targetOf([told(9, state)]), null, state);
  assert.equal(targetOf([told(9, "completed"), told(7, "acknowledged")])?.id, 7);
  assert.equal(targetOf([told(7, "sent", { target: {} })]), null); // a motion that somebody holds
  const before: CommandInfo = { ...told(7, "sent") };
  delete before.target; // from a portal of before
  assert.equal(targetOf([before]), null);
});

test("a recording has the target of the command that ran at the moment played, and none before it and after its end", () => {
  const stage = (after_ms: number, state: string, target: Target) => ({ ...told(7, state, { target }), after_ms });
  const goes = { words: "Move 7", place: { x: 0.1, y: 0.4 } };
  const commands = [
    stage(1000, "accepted", {}),
    stage(2000, "sent", goes),
    stage(4000, "acknowledged", goes),
    stage(9000, "completed", {}),
  ];
  const index = { began_ms: 0, ended_ms: 20_000, end: "", needs: [0], cameras: [], pictures: 0, commands, events: [] };
  const about = { index: "", slices: "", slug: "mercury", name: "Mercury", who: "ada" };
  const story = new Story(index, about);
  const at = (ms: number) => targetOf(story.snapshot(ms, false).commands);
  for (const ms of [0, 1500, 9000, 15_000]) assert.equal(at(ms), null, String(ms));
  for (const ms of [2000, 8999]) assert.deepEqual(at(ms), { ...goes, id: 7 });
  const old = commands.map(({ target: _, ...before }) => before); // recorded before targets were told
  assert.equal(targetOf(new Story({ ...index, commands: old }, about).snapshot(5000, false).commands), null);
});

const PATH: PathPacket = { command: 7, beganMs: 0, seconds: 2, knots: [[0, 0], [1, 0.5]], velocity: [] }; // prettier-ignore

test("an arm's end and way are shown once while its command runs, and taken away when it ends or another one moves", () => {
  const shown: (number[] | null)[] = [];
  let way: number[][] = [];
  const view = {
    toolAt: (q: readonly number[]) => [q[0]!, q[1]!, 0],
    goesTo: (q: readonly number[] | null, path: readonly number[][] = []) => {
      shown.push(q && [...q]);
      way = path.map((p) => [...p]);
    },
  };
  const page = { target: null as { id: number } | null, state: { joints: [0, 0, 0.04] } };
  const goal = new WatchedGoal(() => page);
  goal.draw(view);
  goal.begin(PATH);
  goal.draw(view);
  assert.deepEqual(shown, [], "no command is known to run");
  page.target = { id: 7 };
  goal.draw(null); // the view is not there yet
  goal.draw(view);
  goal.draw(view);
  assert.deepEqual(shown, [[1, 0.5, 0.04]], "the gripper stays as it is");
  assert.equal(way.length, 25);
  assert.deepEqual([way[0], way.at(-1)], [[0, 0, 0], [1, 0.5, 0]]); // prettier-ignore
  page.target = { id: 8 };
  goal.draw(view);
  assert.deepEqual(shown.at(-1), null, "the path of another command");
  goal.begin({ ...PATH, command: 8, knots: [[1, 0.5], [0, 1]] }); // prettier-ignore
  goal.draw(view);
  assert.deepEqual(shown.at(-1), [0, 1, 0.04]);
  page.target = null;
  goal.draw(view);
  assert.deepEqual([shown.length, shown.at(-1)], [4, null]);
  page.target = { id: 2 ** 32 + 8 }; // a path tells the number of its command in 32 bits
  goal.draw(view);
  assert.deepEqual(shown.at(-1), [0, 1, 0.04]);
});

test("Mercury's cross for who watches is at the pixel that sends the arm there", () => {
  const draw = seededDraw(5);
  for (let n = 0; n < 200; n++) {
    const map: Map2 = { matrix: [[draw(4e-4, 9e-4), draw(-2e-4, 2e-4), draw(-0.01, 0.01)], [draw(-2e-4, 2e-4), draw(-9e-4, -4e-4), draw(-0.01, 0.01)]], theta: draw(-3, 3) }; // prettier-ignore
    const pose = [draw(-0.3, 0.3), draw(0.2, 0.6), 0.1, draw(-3, 3)];
    const [u, v] = [draw(0, 191), draw(0, 164)];
    const [x, y] = pixel(map, pose, target(map, pose, u, v, 192, 165), 192, 165);
    assert.ok(Math.hypot(x - u, y - v) < 1e-6, `${[x, y]} is not ${[u, v]}`);
  }
});
