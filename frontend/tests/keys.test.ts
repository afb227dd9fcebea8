/** Keys that a person chooses: no two actions have one, Stop keeps its own, and what is stored is never trusted. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { type KeyAction, KeyChoice, keyInWords, keyOf, shownKey, STOP } from "../src/kit/keys.ts";
import { seededDraw } from "./helpers.ts";

const ACTIONS: KeyAction[] = [
  { name: STOP, use: "stop", key: "" },
  { name: "keys", use: "this list", key: "?" },
  { name: "up", use: "up", key: "u" },
  { name: "down", use: "down", key: "d" },
  { name: "longer", use: "longer steps", key: "+" },
];
const FIXED = ["enter", " ", "arrowup", "arrowdown", "arrowleft", "arrowright", "pageup", "pagedown", "home", "end"];
const press = (key: string, more: object = {}): string => keyOf({ key, ctrlKey: false, metaKey: false, altKey: false, ...more });

test("a key is the character, whatever its case, and none with Ctrl, Alt or the browser's other", () => {
  assert.equal(press("U"), "u");
  assert.equal(press("Г"), "г", "also of another layout");
  for (const held of ["ctrlKey", "metaKey", "altKey"]) assert.equal(press("u", { [held]: true }), "");
  assert.equal(new KeyChoice(ACTIONS).action(""), "", "no action has the key of none");
});

test("what the page shows of a key names it again", () => {
  for (const key of ["u", "+", "-", "?", "7", "ä", "ß", "г", "ي"]) assert.equal(shownKey(keyInWords(key)), key, key);
  assert.equal(keyInWords("-"), "−");
  assert.equal(keyInWords("ß"), "ß", "its capital would be two letters");
});

test("a chosen key counts, the one before no more, and a reset brings it back", () => {
  const keys = new KeyChoice(ACTIONS);
  assert.equal(keys.choose("up", "k"), "");
  assert.deepEqual([keys.action("k"), keys.action("u"), keys.key("up")], ["up", "", "k"]);
  assert.equal(keys.choose("down", "u"), "", "it is free now");
  assert.equal(keys.choose("down", "u"), "", "a key that it has already");
  assert.ok(!keys.isDefault);
  keys.reset();
  assert.deepEqual([keys.action("k"), keys.action("u"), keys.isDefault], ["", "up", true]);
  keys.choose("up", "u");
  assert.ok(keys.isDefault, "the first key is no choice to store");
});

test("a key in use is refused with its use, and fixed ones and those of Stop always", () => {
  const keys = new KeyChoice(ACTIONS);
  assert.equal(keys.choose("down", "u"), "U is in use: up. Choose another.");
  assert.equal(keys.choose("down", "s"), "S is a key of Stop, and stays one.");
  assert.equal(keys.choose(STOP, "u"), "U is in use: up. Choose another.");
  for (const key of [...FIXED, "s", "escape"]) assert.notEqual(keys.choose("up", key), "", key);
  for (const key of ["", "dead", "f5", "ab", "process", "\t"])
    assert.equal(keys.choose("up", key), "Choose a letter, a digit or a sign.", key);
  assert.ok(keys.isDefault);
});

test("Stop may get one more key, and Escape and S stop whatever is chosen or stored", () => {
  const keys = new KeyChoice(ACTIONS);
  assert.equal(keys.choose(STOP, "x"), "");
  assert.deepEqual(["x", "s", "escape"].map((key) => keys.action(key)), [STOP, STOP, STOP]); // prettier-ignore
  keys.restore(JSON.stringify({ up: "s", down: "escape", longer: " " }));
  assert.deepEqual([keys.action("s"), keys.action("escape"), keys.key("up"), keys.isDefault], [STOP, STOP, "u", true]);
});

test("whatever is chosen, in any order, no two actions share a key, and what is stored brings all back", () => {
  const letters = [..."abcdsu?+7ßг", "Enter", "escape", " ", "f1", ""];
  for (let seed = 0; seed < 300; seed++) {
    const draw = seededDraw(seed),
      one = <T>(all: readonly T[]): T => all[Math.floor(draw(0, all.length - 1e-9))]!;
    const keys = new KeyChoice(ACTIONS);
    for (let i = 0; i < 25; i++) {
      const { name } = one(ACTIONS),
        key = one(letters).toLowerCase(),
        why = keys.whyNot(name, key);
      assert.equal(keys.choose(name, key), why);
      if (!why) assert.equal(keys.key(name), key);
    }
    const used = ACTIONS.map(({ name }) => keys.key(name)).filter(Boolean);
    assert.equal(new Set(used).size, used.length, `${seed}`);
    for (const { name } of ACTIONS) if (keys.key(name)) assert.equal(keys.action(keys.key(name)), name);
    const again = new KeyChoice(ACTIONS);
    again.restore(keys.stored);
    assert.deepEqual(
      ACTIONS.map(({ name }) => again.key(name)),
      ACTIONS.map(({ name }) => keys.key(name)),
      "also of two that have changed places",
    );
  }
});

test("what a browser has stored is taken as far as it could be chosen", () => {
  const read = (stored: string | null): KeyChoice => {
    const keys = new KeyChoice(ACTIONS);
    keys.restore(stored);
    return keys;
  };
  for (const bad of [null, "", "{", "7", "null", "[]", '{"up": 7}', '{"up": "kk"}', '{"other": "k"}', '{"__proto__": "k"}', '{"up": "K"}'])
    assert.ok(read(bad).isDefault, bad ?? "nothing");
  assert.ok(read(`{"up": "k", "more": "${"x".repeat(2000)}"}`).isDefault, "too long");
  const doubled = read('{"up": "d", "longer": "l"}');
  assert.deepEqual([doubled.key("up"), doubled.key("down"), doubled.key("longer")], ["u", "d", "l"]);
});
