/** Cheers for who drives: when the button works, what is shown to whom, and how often a screen reader is told. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import type { Snapshot } from "../src/socket/messages.ts";
import { browse } from "./browser.ts";
import { stub } from "./helpers.ts";

const ROW = `<span id="cheers"></span><button id="cheer"></button><label id="cheers-choice"><input type="checkbox" id="cheers-shown"></label>
  <span id="cheer-said"></span><span id="cheers-heard"></span>`;
const document = browse(ROW);
const stored = new Map<string, string>();
let now = 0,
  reduced = false,
  moved = 0,
  sent = 0,
  refused = "";
stub({
  performance: { now: () => now },
  matchMedia: () => ({ matches: reduced }),
  localStorage: { getItem: (key: string) => stored.get(key) ?? null, setItem: (key: string, value: string) => stored.set(key, value) },
});
const { Cheers, cheerWords } = await import("../src/page/cheers.ts");

const text = (id: string): string => document.getElementById(id)!.textContent;
const button = (): HTMLElement => document.getElementById("cheer")!;
const page = (drive: boolean, grant = 7, cheers = true): Snapshot =>
  ({ me: { can: { drive } }, turn: grant ? { grant, cheers } : null }) as unknown as Snapshot;
function opened(): InstanceType<typeof Cheers> {
  document.body.innerHTML = ROW;
  document.getElementById("cheers")!.animate = () => (moved++, {}) as Animation;
  return new Cheers(() => sent++, { refuse: (why) => (refused = why()) });
}

beforeEach(() => {
  [now, reduced, moved, sent, refused] = [100_000, false, 0, 0, ""];
  stored.clear();
});

test("the words are short however many cheer", () => {
  assert.deepEqual([0, 1, 2, 999, 1000, 2 ** 40].map(cheerWords), [
    "",
    "1 cheer",
    "2 cheers",
    "999 cheers",
    "over 999 cheers",
    "over 999 cheers",
  ]);
});

test("a press sends one cheer in five seconds, and is refused in words meanwhile", () => {
  const cheers = opened();
  cheers.draw(page(false), true);
  button().click();
  cheers.answer(true);
  cheers.draw(page(false), true);
  button().click();
  assert.deepEqual([sent, text("cheer-said")], [1, "You cheered."]);
  assert.match(refused, /again/);
  now += 5000;
  cheers.draw(page(false), true);
  button().click();
  assert.deepEqual([sent, text("cheer-said")], [2, ""]);
});

test("where nobody can be cheered a press says why and sends nothing", () => {
  const cheers = opened();
  const cases: [Snapshot, boolean, RegExp][] = [
    [page(false, 0), true, /Nobody drives/],
    [page(false, 7, false), true, /switched cheering off/],
    [page(false), false, /connection/],
  ];
  for (const [snapshot, up, why] of cases) {
    cheers.draw(snapshot, up);
    button().click();
    assert.match(refused, why);
  }
  assert.equal(sent, 0);
});

test("a count is shown in its own turn alone, and it moves only where motion is wanted", () => {
  for (reduced of [false, true]) {
    const cheers = opened();
    cheers.take({ t: "cheers", grant: 7, count: 3 });
    cheers.draw(page(false), true);
    cheers.draw(page(false), true);
    assert.equal(text("cheers"), ", 3 cheers");
    assert.equal(moved, 1, "once, and not where motion is reduced");
    cheers.draw(page(false, 8), true);
    assert.equal(text("cheers"), "");
    cheers.draw(page(false, 0), true);
    assert.equal(text("cheers"), "");
  }
});

test("who drives has a choice in place of the button, which this browser remembers", () => {
  let cheers = opened();
  cheers.take({ t: "cheers", grant: 7, count: 3 });
  cheers.draw(page(true), true);
  assert.deepEqual([button().hidden, document.getElementById("cheers-choice")!.hidden, text("cheers")], [true, false, ", 3 cheers"]);
  document.getElementById("cheers-shown")!.click();
  cheers.draw(page(true), true);
  assert.deepEqual([text("cheers"), text("cheers-heard")], ["", ""]);
  cheers = opened();
  cheers.take({ t: "cheers", grant: 7, count: 4 });
  cheers.draw(page(true), true);
  assert.equal(text("cheers"), "");
  cheers.draw(page(false), true);
  assert.equal(text("cheers"), ", 4 cheers", "it is a driver's choice");
});

test("a screen reader is told at most every ten seconds, and the newest count", () => {
  const cheers = opened(),
    heard: [number, string][] = [];
  for (let second = 0; second < 35; second++, now += 1000) {
    cheers.take({ t: "cheers", grant: 7, count: second + 2 });
    cheers.draw(page(false), true);
    if (text("cheers-heard") !== heard.at(-1)?.[1]) heard.push([second, text("cheers-heard")]);
  }
  assert.deepEqual(heard, [
    [0, "2 cheers."],
    [10, "12 cheers."],
    [20, "22 cheers."],
    [30, "32 cheers."],
  ]);
});
