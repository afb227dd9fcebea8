/** The objects around an arm, as the page is told of them. Lengths in m. */
import { gettext } from "../kit/text.ts";

/** An object as `object_facts` of robots/kit/arms/objects.py tells it: its size in m, colour from 0 to 1, poses 4 x 4. */
export interface ObjectFacts {
  name: string;
  number: number;
  shape: "box" | "cylinder";
  size: [number, number, number];
  colour: [number, number, number];
  turns: number; // by so many equal turns about its z it looks the same
  carries?: string[]; // what may be put on it; "*": everything
  first?: number[]; // its pose in the beginning
  grasps?: number[][]; // poses of the tool in its frame
  hangs?: boolean; // nothing has to be beneath it
}
/** A plate with studs: the middle of its underside (m), columns along x and rows along y. */
export interface PlateFacts {
  place: [number, number, number];
  studs: [number, number];
  pitch: number; // m between two studs
  thick: number;
}
/** Return how long ago the newest picture showed an object, as "seen 12 s ago"; empty where none has. */
export function seenInWords({ how, atMs }: Pick<KnownObject, "how" | "atMs">, now: number): string {
  if (how !== "measured" || !Number.isFinite(atMs)) return "";
  const seconds = Math.max(0, Math.round((now - atMs) / 1000));
  if (seconds < 120) return gettext("seen {seconds} s ago", { seconds });
  return seconds < 7200
    ? gettext("seen {minutes} min ago", { minutes: Math.floor(seconds / 60) })
    : gettext("seen {hours} h ago", { hours: Math.floor(seconds / 3600) });
}
/** What is known of an object. `pose` is in the frame of the base, or of the tool that holds it. */
export interface KnownObject {
  facts: ObjectFacts;
  pose: Float64Array;
  held: boolean;
  planned?: boolean; // it is there by a task that is recorded, not in truth
  how: string; // how its place was last known,
  atMs: number; // and when (ms since 1970); NaN where that is not told
}
