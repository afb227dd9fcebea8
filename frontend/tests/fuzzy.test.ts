/** The page's rules are the rover's (tests/unit/test_fuzzy_vectors.py). */
import assert from "node:assert/strict";
import { test } from "node:test";
import { speed } from "../../robots/kit/drivers/srv1/console/fuzzy.ts";
import { braking, type Made, wrongIn } from "../../robots/kit/drivers/srv1/console/rules_check.ts";
import { crcOf, parse, write } from "../../robots/kit/drivers/srv1/console/rules_text.ts";
import { vectorsOf } from "./helpers.ts";

interface Vectors {
  made: Made;
  sets: { text: string; crc: number; refusal: string; cases: [number, number, number][] }[];
  texts: { text: string; refusal: string }[];
}
const vectors = vectorsOf<Vectors>("fuzzy");
const { made } = vectors; // of robot.toml, as the page gets it

/** What the page says of a text: why it cannot be read, or all that is wrong with it. */
function said(text: string): string[] {
  try {
    return wrongIn(parse(text), braking(made)).map(({ words }) => words);
  } catch (error) {
    return [(error as Error).message];
  }
}

/** Without the figures, which the two languages round differently, and without quotation marks. */
const core = (words: string): string =>
  words
    .replace(/ (is too fast|gives up to).*$/, " $1")
    .replace(/[“”'"][^]*$/, "")
    .replace(/; .*$/, "")
    .replace(/\.$/, "");

test("speeds are the rover's, by either method, also at the peaks and beyond them", () => {
  for (const { text, cases } of vectors.sets)
    for (const [a, b, wanted] of cases) assert.ok(Math.abs(speed(parse(text), a, b) - wanted) < 1e-9, `${text} ${a} ${b}: ${wanted}`);
});

test("a set is written as it was read, and called by the same number", () => {
  for (const { text, crc } of vectors.sets) {
    assert.equal(write(parse(text)), text);
    assert.equal(crcOf(text), crc);
  }
});

test("the page refuses what the rover refuses, for the same reason, and nothing else", () => {
  for (const { text, refusal } of [...vectors.sets, ...vectors.texts]) {
    const told = said(text);
    if (!refusal) assert.deepEqual(told, [], text);
    else assert.ok(told.map(core).includes(core(refusal)), `${refusal}\n${told.join("\n")}`);
  }
});

test("each wrong rule is named with its pair", () => {
  const paper = parse(vectors.sets[0]!.text);
  paper.table[1]![4] = 4;
  paper.table[2]![2] = -1;
  const found = wrongIn(paper, braking(made));
  assert.equal(found.map(({ rule }) => rule).join(" "), "1,4 2,2");
  assert.match(found[0]!.words, /^Rule 10 \(infrared N, sonar VF\) is too fast: 0\.40 m\/s takes 0\.23 m to stop/);
  assert.ok(Number.isNaN(speed(paper, 0.45, 6)), "no speed where a pair that counts has no rule");
  assert.equal(speed(paper, 0.15, 2), 0.08);
});
