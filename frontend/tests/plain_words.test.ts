/** A robot's own words are shown as plain ones, with its own beside them. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { browse } from "./browser.ts";

const description = { commands: [], words: { S1: "Shoulder turn", "PROG EXEC": "runs a program" } };
const document = browse(`<script type="application/json" id="description">${JSON.stringify(description)}</script><p id="mode"></p>`);
const { plain, sayWord } = await import("../src/page/plain_words.ts");

function shown(told: string): [text: string, small: string[]] {
  const box = document.getElementById("mode")!;
  sayWord(box, told);
  return [box.textContent.trim(), [...box.querySelectorAll("small")].map((one) => one.textContent)];
}

test("the plain word comes first, the robot's own after it and small", () => {
  assert.deepEqual(shown("S1"), ["Shoulder turn S1", ["S1"]]);
  assert.equal(plain("S1"), "Shoulder turn");
});

test("what follows a colon stays", () => {
  assert.deepEqual(shown("PROG EXEC: program 2, step 3"), ["runs a program: program 2, step 3 PROG EXEC", ["PROG EXEC"]]);
});

test("a word that has no plain one is shown once", () => {
  assert.deepEqual(shown("exploring"), ["exploring", []]);
  assert.deepEqual(shown(""), ["", []]);
});
