/** Reads the byte stream `earlier`: the map before this one, with why and when it was cleared. */
import { ExperienceMap } from "./map_packets.ts";

const VERSION = 1;
const HEAD = 14;
const WHY = [
  (minutes: string) => `it was ${minutes} old and nobody's goal waited`,
  (minutes: string) => `it was ${minutes} old, and a map is kept for 20 minutes at most`,
  () => "staff cleared it",
  () => "it could not be read when the robot's software was started again",
] as const;
const RULE = "As in its paper, the robot begins a new map after 10 to 20 minutes outside its dock.";

export interface Earlier {
  map: ExperienceMap;
  endedMs: number;
  why: string;
}

/** Read a packet; null for one that cannot be read. */
export function earlierOf(data: Uint8Array): Earlier | null {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength),
    map = new ExperienceMap();
  if (data.byteLength < HEAD || view.getUint8(0) !== VERSION || !map.take(data.subarray(HEAD), true)) return null;
  const minutes = Math.round(view.getFloat32(2, true) / 60),
    why = WHY[view.getUint8(1)];
  return { map, endedMs: Number(view.getBigUint64(6, true)), why: why?.(minutes === 1 ? "1 minute" : `${minutes} minutes`) ?? "" };
}

/** Return in words how it ended. `at`: the time of day, in words. */
export function endOf({ map, why }: Earlier, at: string): string {
  const rule = why.startsWith("it was") ? ` ${RULE}` : "";
  return `Map ${map.number} ended at ${at}${why ? `, because ${why}` : ""}; a new map was begun.${rule}`;
}
