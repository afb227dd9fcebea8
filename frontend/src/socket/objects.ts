/** Reads where things lie around a robot (robots/kit/contract/objects.py): 12 bytes an object, deltas hold what has moved. */
import { bitReader } from "./compact_state.ts";

/** A place (m) and a rotation (quaternion x, y, z, w). */
export interface Placed {
  place: [number, number, number];
  rotation: [number, number, number, number];
}
/** The box in which objects lie: its lowest corner and its size (m). */
export interface Box {
  low: [number, number, number];
  size: [number, number, number];
}

const SIZE = 12,
  PLACES = 65534,
  GONE = 65535,
  TURNS = 8190,
  HALF = Math.SQRT1_2;

/** Return the objects after a packet; null if it cannot be read. `known`: those before, which a delta changes. */
export function objectsAfter(known: ReadonlyMap<number, Placed>, data: Uint8Array, key: boolean, box: Box): Map<number, Placed> | null {
  if (data.length % SIZE) return null;
  const after = new Map(key ? [] : known);
  for (let at = 0; at < data.length; at += SIZE) {
    const take = bitReader(data, at);
    const number = take(7),
      codes = [take(16), take(16), take(16)],
      largest = take(2),
      turns = [take(13), take(13), take(13)];
    if (codes[0] === GONE) {
      after.delete(number);
      continue;
    }
    if (Math.max(...codes) > PLACES || Math.max(...turns) > TURNS) return null;
    const others = turns.map((code) => (code / TURNS) * 2 * HALF - HALF);
    others.splice(largest, 0, Math.sqrt(Math.max(0, 1 - others.reduce((sum, one) => sum + one * one, 0))));
    const place = codes.map((code, n) => box.low[n]! + (code / PLACES) * box.size[n]!);
    after.set(number, { place: place as Placed["place"], rotation: others as Placed["rotation"] });
  }
  return after;
}
