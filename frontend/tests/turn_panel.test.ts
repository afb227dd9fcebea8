/** Control that one press asks for: the offer is accepted as it comes, unless one has changed one's mind. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import type { Snapshot } from "../src/socket/messages.ts";
import { browse } from "./browser.ts";

const document = browse();
const { TurnPanel } = await import("../src/queue/turn_panel.ts");
let box = document.createElement("section");
let sent: string[] = [];
let silent = false; // nothing has come since the last press

function panel(wanted = false): InstanceType<typeof TurnPanel> {
  box = document.createElement("section");
  const live = { send: (message: object) => sent.push((message as { t: string }).t) > 0, heardSince: (at: number) => !silent || at < 0 };
  return new TurnPanel(box, { live, refuse: () => undefined }, wanted);
}

/** Return what a cleared person is told: that the robot is free or not, and the state of their ticket. */
function told(free: boolean, ticket: string | null = null): Snapshot {
  const me = { signed_in: true, cleared: true, can: { drive: false }, ticket: ticket && { state: ticket, ahead: 0, wait_s: null } };
  return { robot: { slug: "arm", state: "ready", turns: true, free }, queue: free ? 0 : 1, turn: null, me } as unknown as Snapshot;
}

function press(action: string): void {
  const button = document.createElement("button");
  button.dataset["do"] = action;
  box.append(button);
  button.click();
  button.remove();
}

beforeEach(() => {
  sent = [];
  silent = false;
});

test("one press takes control of a free robot, once", () => {
  const one = panel();
  one.changed(told(true));
  press("take");
  for (const state of ["waiting", "offered", "offered"]) one.changed(told(false, state));
  assert.deepEqual(sent, ["join", "accept"]);
});

test("who leaves the queue and joins again decides about the offer", () => {
  const one = panel();
  press("take");
  press("leave");
  press("join");
  one.changed(told(false, "offered"));
  assert.deepEqual(sent, ["join", "leave", "join"]);
});

test("who only joined decides about the offer", () => {
  const one = panel();
  press("join");
  one.changed(told(false, "offered"));
  assert.deepEqual(sent, ["join"]);
});

test("the wish of the page before is carried out at once, or not at all", () => {
  const one = panel(true);
  one.changed(told(true));
  one.changed(told(false, "offered"));
  assert.deepEqual(sent, ["join", "accept"]);
  const other = panel(true);
  other.changed(told(false));
  other.changed(told(true));
  assert.deepEqual(sent, ["join", "accept"], "somebody else was faster");
});

test("a press before the line was lost may have arrived, and its repeat is not called unsent", () => {
  const one = panel();
  silent = true;
  one.draw(told(false, "waiting"), 0, false);
  assert.match(box.innerHTML, /could not be sent/);
  press("leave");
  one.draw(told(false, "waiting"), 0, false);
  assert.match(box.innerHTML, /whether that was done is not known/);
  assert.doesNotMatch(box.innerHTML, /could not be sent/);
  silent = false;
  one.draw(told(false, "waiting"), 0, false);
  assert.match(box.innerHTML, /could not be sent/, "the portal was heard after that press, and then lost");
});

const WAITS: [state: string, wait: [number, number] | null, said: RegExp][] = [
  ["in_use", [65, 400], /1 in the queue\.Your wait: about 2 min to 7 min/],
  ["in_use", [0, 30], /1 in the queue\.Your wait: less than a minute/],
  ["in_use", null, /1 in the queue\.Your wait: not known now/],
  ["offline", null, /1 in the queue\.Join the queue/],
];

for (const [state, wait, said] of WAITS)
  test(`who could join a robot that is ${state} reads how long they would wait, ${wait?.join(" to ") ?? "unknown"}`, () => {
    const one = panel(),
      now = told(false);
    one.draw({ ...now, robot: { ...now.robot, state }, join_wait_s: wait }, 0, true);
    assert.match(box.textContent, said);
  });

test("who can drive at once reads of no wait", () => {
  const one = panel();
  one.draw({ ...told(true), join_wait_s: [0, 0] }, 0, true);
  assert.doesNotMatch(box.textContent, /wait:/);
});
