/** What the arm's console says of values that are filled in. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { rangeError } from "../src/arm/types.ts";

test("a value outside its range is refused in the field's own unit", () => {
  const range = { low: -1.6, high: 1.6 };
  assert.equal(rangeError("x", 9999, "mm", 1000, range), "x must lie between -1600 and 1600 mm.");
  assert.equal(rangeError("x", 1600, "mm", 1000, range), "");
});
