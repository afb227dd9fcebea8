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

/** Return what a person is told of a robot that moves by itself while nobody waits. */
function roaming(ticket: string | null = null, ahead = 0): Snapshot {
  const s = told(false, ticket);
  const t = s.me.ticket && { ...s.me.ticket, ahead };
  return { ...s, queue: ticket ? 1 : 0, robot: { ...s.robot, soon: !ticket }, me: { ...s.me, ticket: t }, join_wait_s: [0, 12] };
}

function buttons(): (string | null)[] {
  return [...box.querySelectorAll("button")].map((one) => `${one.textContent} ${one.dataset["do"]} ${one.getAttribute("aria-disabled")}`);
}

/** Tell the panel, and draw it. */
function tell(one: InstanceType<typeof TurnPanel>, s: Snapshot): void {
  one.changed(s);
  one.draw(s, 0, true);
}

test("a robot that moves by itself is taken by one press, and the page says when it begins", () => {
  const one = panel();
  tell(one, roaming());
  assert.match(box.textContent, /Nobody waits: it is yours in some seconds\./);
  assert.doesNotMatch(box.textContent, /wait:/);
  press("take");
  for (const state of ["waiting", "offered"]) tell(one, roaming(state));
  assert.deepEqual(sent, ["join", "accept"]);
});

test("the page of before takes control of a robot that moves by itself", () => {
  panel(true).changed(roaming());
  assert.deepEqual(sent, ["join"]);
});

test("from the press until the turn the page says that it asks, and its button stays", () => {
  const one = panel();
  tell(one, roaming());
  const [button] = box.querySelectorAll("button");
  press("take");
  const asks = ["Take control take true", "Cancel leave false"];
  assert.deepEqual(buttons(), asks, "at once");
  for (const state of [null, "waiting", "offered", "offered"]) {
    tell(one, roaming(state));
    assert.deepEqual(buttons(), asks);
    assert.match(box.textContent, /Asking for control…/);
    assert.doesNotMatch(box.textContent, /You are next|It is your turn/);
    assert.equal(box.querySelector("button"), button);
    assert.ok(box.hasAttribute("data-asking"));
  }
  const turn = { mine: true, until_ms: 60_000 };
  const driving = roaming();
  tell(one, { ...driving, turn, me: { ...driving.me, can: { drive: true } } } as unknown as Snapshot);
  assert.match(box.textContent, /You drive/);
  assert.ok(!box.hasAttribute("data-asking"));
});

test("what is asked for can be cancelled", () => {
  const one = panel();
  tell(one, roaming());
  press("take");
  tell(one, roaming("waiting"));
  press("leave");
  tell(one, roaming("offered"));
  assert.deepEqual(sent, ["join", "leave"]);
  assert.match(box.textContent, /It is your turn/);
});

const ENDS: [why: string, then: (one: InstanceType<typeof TurnPanel>) => Snapshot, said: RegExp][] = [
  ["the portal refuses", (one) => (one.refused(), roaming()), /it is yours in some seconds\.Take control$/],
  ["somebody else was faster", () => roaming("waiting", 1), /1 before you/],
  ["the robot fails", () => ({ ...roaming("waiting"), robot: { ...roaming("waiting").robot, state: "fault" } }), /You are next/],
  ["the place is gone", (one) => (one.changed(roaming("waiting")), roaming()), /Take control$/],
];

for (const [why, then, said] of ENDS)
  test(`the page asks for control no more once ${why}`, () => {
    const one = panel();
    tell(one, roaming());
    press("take");
    tell(one, then(one));
    assert.doesNotMatch(box.textContent, /Asking/);
    assert.match(box.textContent, said);
  });

test("an offer that is accepted and a queue that is joined say so at once", () => {
  const one = panel();
  tell(one, roaming("offered"));
  press("accept");
  assert.match(box.textContent, /Asking for control….*Take control.*Not now/);
  assert.deepEqual(buttons(), ["Take control accept true", "Not now leave false"]);
  tell(one, roaming("waiting"));
  assert.doesNotMatch(box.textContent, /Asking/, "it was taken back");
  const other = panel();
  tell(other, told(false));
  press("join");
  assert.match(box.textContent, /Asking for a place in the queue…/);
  assert.deepEqual(buttons(), ["Join the queue join true"]);
  tell(other, told(false, "waiting"));
  assert.doesNotMatch(box.textContent, /Asking/);
});

test("who has read the orientation has one step to go, to the test", () => {
  const one = panel(),
    s = told(false);
  const steps = (read: boolean): string => {
    one.draw({ ...s, me: { ...s.me, cleared: false, read } }, 0, true);
    return `${box.querySelector("h2")?.textContent} ${box.querySelector("a")?.getAttribute("href")}`;
  };
  assert.equal(steps(false), "Two steps to go /robots/arm/orientation/");
  assert.equal(steps(true), "One step to go /robots/arm/clearance/");
});
