/** The iRat's byte streams, read as they are packed (tests/unit/test_irat_vectors.py); broken ones change nothing shown. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { PoseCells } from "../../robots/kit/drivers/irat/console/cell_packets.ts";
import { ExperienceMap } from "../../robots/kit/drivers/irat/console/map_packets.ts";
import { bytesOf, vectorsOf } from "./helpers.ts";

interface Packet {
  hex: string;
  key: boolean;
}
interface Vectors {
  map: {
    what: string;
    packets: Packet[];
    shown: Pick<ExperienceMap, "number" | "links" | "route" | "docks"> & { spots: Record<string, [number, number]>; dock: number[] | null };
  }[];
  cells: { what: string; packets: Packet[]; shown: Record<string, number> }[];
}
const vectors = vectorsOf<Vectors>("irat_streams");

for (const one of vectors.map)
  test(`map: ${one.what}`, () => {
    const map = new ExperienceMap();
    for (const { hex, key } of one.packets) assert.ok(map.take(bytesOf(hex), key));
    const spots = Object.fromEntries([...map.spots].map(([id, { x, y }]) => [id, [x, y]]));
    assert.deepEqual(Object.keys(spots).sort(), Object.keys(one.shown.spots).sort());
    for (const [id, [x, y]] of Object.entries(one.shown.spots)) {
      assert.ok(Math.abs(spots[id]![0]! - x) < 1e-9, `${id}: ${spots[id]}`);
      assert.ok(Math.abs(spots[id]![1]! - y) < 1e-9, `${id}: ${spots[id]}`);
    }
    const dock = map.dock && [map.dock.x, map.dock.y, map.dock.within].map((v) => Math.round(v * 1000) / 1000);
    assert.deepEqual(dock, one.shown.dock);
    assert.deepEqual([map.number, map.links, map.route, map.docks], [one.shown.number, one.shown.links, one.shown.route, one.shown.docks]);
  });

for (const one of vectors.cells)
  test(`cells: ${one.what}`, () => {
    const cells = new PoseCells();
    for (const { hex, key } of one.packets) assert.ok(cells.take(bytesOf(hex), key));
    const active = [...cells.levels.entries()].filter(([, level]) => level);
    assert.deepEqual(Object.fromEntries(active), one.shown);
  });

test("a packet that is cut, of another version or of another map is refused, and the map stays as it was", () => {
  for (const { packets } of vectors.map) {
    const whole = bytesOf(packets[0]!.hex);
    for (let end = 0; end < whole.length; end++) {
      const map = new ExperienceMap();
      assert.equal(map.take(whole.slice(0, end), true), false, `cut at ${end}`);
      assert.equal(map.spots.size, 0);
    }
    assert.equal(new ExperienceMap().take(Uint8Array.from([9, ...whole.slice(1)]), true), false);
    const [map, other] = [new ExperienceMap(), Uint8Array.from(whole)];
    assert.ok(map.take(whole, true));
    other[2] = 99;
    assert.equal(map.take(other, false), false, "a delta of another map");
    assert.notEqual(map.number, 99);
  }
  const huge = bytesOf(vectors.map[0]!.packets[0]!.hex);
  huge.fill(255, 6, 14);
  assert.equal(new ExperienceMap().take(huge, true), false, "more places than it has bytes");
});

test("places at the dock are not open to people, and all are where the dock is not known", () => {
  const map = new ExperienceMap();
  const { packets } = vectors.map.find(({ shown }) => shown.dock)!;
  for (const { hex, key } of packets) map.take(bytesOf(hex), key);
  assert.deepEqual([...map.open().keys()], [2]);
  map.dock = null;
  assert.equal(map.open().size, map.spots.size);
});

test("cells out of range and half a cell are refused", () => {
  const cells = new PoseCells();
  assert.equal(cells.take(Uint8Array.from([1]), true), false);
  assert.equal(cells.take(Uint8Array.from([255, 255]), true), false);
});
