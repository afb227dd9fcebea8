/** Reads the byte stream `earlier`: the map before this one, with why and when it was cleared. */
import { ExperienceMap } from "./map_packets.ts";
import { gettext, ngettext } from "/static/farhand/v1/text.js";

const VERSION = 1;
const HEAD = 14;
type Values = { number: number; at: string };
const ENDS = [
  (minutes: number, values: Values) =>
    ngettext(
      "Map {number} ended at {at}, because it was {count} minute old and nobody's goal waited; a new map was begun.",
      "Map {number} ended at {at}, because it was {count} minutes old and nobody's goal waited; a new map was begun.",
      minutes,
      values,
    ),
  (minutes: number, values: Values) =>
    ngettext(
      "Map {number} ended at {at}, because it was {count} minute old, and a map is kept for 20 minutes at most; a new map was begun.",
      "Map {number} ended at {at}, because it was {count} minutes old, and a map is kept for 20 minutes at most; a new map was begun.",
      minutes,
      values,
    ),
  (_: number, values: Values) => gettext("Map {number} ended at {at}, because staff cleared it; a new map was begun.", values),
  (_: number, values: Values) =>
    gettext(
      "Map {number} ended at {at}, because it could not be read when the robot's software was started again; a new map was begun.",
      values,
    ),
] as const;
const BY_AGE = 2; // the first of them
const RULE = gettext("As in its paper, the robot begins a new map after 10 to 20 minutes outside its dock.");

export interface Earlier {
  map: ExperienceMap;
  endedMs: number;
  minutes: number;
  /** Which of `ENDS` it was; a number that is none came later. */
  why: number;
}

/** Read a packet; null for one that cannot be read. */
export function earlierOf(data: Uint8Array): Earlier | null {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength),
    map = new ExperienceMap();
  if (data.byteLength < HEAD || view.getUint8(0) !== VERSION || !map.take(data.subarray(HEAD), true)) return null;
  const minutes = Math.round(view.getFloat32(2, true) / 60);
  return { map, endedMs: Number(view.getBigUint64(6, true)), minutes, why: view.getUint8(1) };
}

/** Return in words how it ended. `at`: the time of day, in words. */
export function endOf({ map, minutes, why }: Earlier, at: string): string {
  const values = { number: map.number, at };
  const end = ENDS[why]?.(minutes, values) ?? gettext("Map {number} ended at {at}; a new map was begun.", values);
  return why < BY_AGE ? `${end} ${RULE}` : end;
}
