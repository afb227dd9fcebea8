/** Reads where things lie around a robot (robots/kit/contract/objects.py): 12 bytes an object, deltas hold what has moved. */
import { bitReader } from "./compact_state.ts";

/** A place (m) and a rotation (quaternion x, y, z, w): in the frame of the base, or in that of the tool that holds it (`held`). */
export interface Placed {
  place: [number, number, number];
  rotation: [number, number, number, number];
  held?: true;
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
  HALF = Math.SQRT1_2,
  REACH = 0.256, // m from the tool's point, along each axis: where an object that is held may be
  HELD_PLACES = 4095,
  HELD_TURNS = 2046;

/** Return the objects after a packet; null if it cannot be read. `known`: those before, which a delta changes. */
export function objectsAfter(known: ReadonlyMap<number, Placed>, data: Uint8Array, key: boolean, box: Box): Map<number, Placed> | null {
  if (data.length % SIZE) return null;
  const after = new Map(key ? [] : known);
  for (let at = 0; at < data.length; at += SIZE) {
    const take = bitReader(data, at);
    const number = take(7),
      first = take(16);
    if (first === GONE) {
      if (take(1)) {
        const held = heldPlace(take);
        if (!held) return null;
        after.set(number, held);
      } else after.delete(number);
      continue;
    }
    const codes = [first, take(16), take(16)],
      largest = take(2),
      turns = [take(13), take(13), take(13)];
    if (Math.max(...codes) > PLACES || Math.max(...turns) > TURNS) return null;
    const place = codes.map((code, n) => box.low[n]! + (code / PLACES) * box.size[n]!);
    after.set(number, { place: place as Placed["place"], rotation: rotationOf(largest, turns, TURNS) });
  }
  return after;
}

/** Return where an object is in the tool that holds it; null if it cannot be read. `take`: reads on after the mark. */
function heldPlace(take: (bits: number) => number): Placed | null {
  const place = [take(12), take(12), take(12)].map((code) => (code / HELD_PLACES) * 2 * REACH - REACH),
    largest = take(2),
    turns = [take(11), take(11), take(11)];
  if (Math.max(...turns) > HELD_TURNS || take(1)) return null;
  return { place: place as Placed["place"], rotation: rotationOf(largest, turns, HELD_TURNS), held: true };
}

function rotationOf(largest: number, codes: number[], steps: number): Placed["rotation"] {
  const rotation = codes.map((code) => (code / steps) * 2 * HALF - HALF);
  rotation.splice(largest, 0, Math.sqrt(Math.max(0, 1 - rotation.reduce((sum, one) => sum + one * one, 0))));
  return rotation as Placed["rotation"];
}
