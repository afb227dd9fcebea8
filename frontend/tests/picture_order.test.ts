/** Which of a camera's pictures are shown. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { PictureOrder } from "../src/media/pictures.ts";

const picture = (atMs: number, number: number): { atMs: number; number: number } => ({ atMs, number });

test("older pictures are dropped, and the same one again", () => {
  const order = new PictureOrder();
  assert.ok(order.take(picture(10_000, 7)));
  assert.ok(!order.take(picture(10_000, 7)));
  assert.ok(!order.take(picture(9_900, 6)));
  assert.ok(!order.take(picture(9_900, 8)), "by time, whatever the number");
  assert.ok(order.take(picture(10_000, 8)), "two in one millisecond");
  assert.ok(order.take(picture(10_100, 9)));
  assert.ok(!order.holds(picture(10_000, 8)));
  assert.ok(order.holds(picture(10_100, 9)));
});

test("pictures of a process that has begun again are shown at once", () => {
  const order = new PictureOrder();
  assert.ok(order.take(picture(10_000, 900)));
  assert.ok(order.take(picture(12_000, 1)));
  assert.ok(order.take(picture(12_100, 2)));
  assert.ok(!order.take(picture(10_100, 901)), "a late one of the old process");
});

test("after a jump in time an earlier picture is shown, and those that follow it", () => {
  const order = new PictureOrder();
  assert.ok(order.take(picture(20_000, 1)));
  assert.ok(!order.take(picture(17_000, 2)), "no jump");
  assert.ok(order.take({ ...picture(17_000, 3), first: true }));
  assert.ok(order.take({ ...picture(17_200, 4), first: false }));
  assert.ok(!order.take(picture(17_100, 5)));
});

test("a clock that was set back far does not end the pictures", () => {
  const order = new PictureOrder();
  assert.ok(order.take(picture(3_600_000, 900)));
  assert.ok(order.take(picture(10_000, 901)));
  assert.ok(order.take(picture(10_100, 902)));
});
