/** The iRat's earlier map: what was cleared, why and when, in words. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { earlierOf, endOf } from "../../robots/kit/drivers/irat/console/earlier_map.ts";

/** A packet: why, age (s), and a map of one place. */
function packet(why: number, age: number, version = 1): Uint8Array {
  const view = new DataView(new ArrayBuffer(14 + 14 + 8));
  view.setUint8(0, version);
  view.setUint8(1, why);
  view.setFloat32(2, age, true);
  view.setBigUint64(6, 1_795_000_000_000n, true);
  view.setUint8(14, 1);
  view.setUint32(16, 12, true);
  view.setUint32(20, 1, true);
  view.setUint32(28, 7, true);
  view.setInt16(32, 200, true);
  view.setInt16(34, -100, true);
  return new Uint8Array(view.buffer);
}

test("a cleared map is read with why and when", () => {
  const earlier = earlierOf(packet(0, 660))!;
  assert.equal(earlier.endedMs, 1_795_000_000_000);
  assert.deepEqual([earlier.map.number, [...earlier.map.spots]], [12, [[7, { x: 1, y: -0.5 }]]]);
  assert.equal(
    endOf(earlier, "14:05"),
    "Map 12 ended at 14:05, because it was 11 minutes old and nobody's goal waited; a new map was begun. As in its paper, the robot begins a new map after 10 to 20 minutes outside its dock.",
  );
  assert.equal(endOf(earlierOf(packet(2, 60))!, "14:05"), "Map 12 ended at 14:05, because staff cleared it; a new map was begun.");
  assert.match(endOf(earlierOf(packet(3, 60))!, "14:05"), /could not be read/);
  assert.equal(endOf(earlierOf(packet(9, 60))!, "14:05"), "Map 12 ended at 14:05; a new map was begun.", "a reason that came later");
});

test("what is cut off, or of another version, is not taken", () => {
  const whole = packet(1, 1200);
  for (let length = 0; length < whole.length; length += 1) assert.equal(earlierOf(whole.slice(0, length)), null);
  assert.equal(earlierOf(packet(0, 1, 2)), null);
});
