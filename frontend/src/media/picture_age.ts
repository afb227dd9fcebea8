/** The age of a picture. */
import { ago } from "../kit/times.ts";

export const LIVE_MS = 5000; // an older picture does not show what is there now
const AHEAD_MS = 2000; // a stamp so far in the future says nothing: some clock is wrong

/** A picture's age in words, and how it is marked; `often`: how many a second come, in words. */
export function pictureAge(ms: number, often = ""): [words: string, mark: "fresh" | "ageing" | "old"] {
  if (ms < -AHEAD_MS) return ["Picture of unknown age", "old"];
  return [`Picture ${ago(ms)} old${often}`, ms < 2000 ? "fresh" : ms < LIVE_MS ? "ageing" : "old"];
}

/** Whether a picture of that age shows what is there now; `lost`: the server is not reached. */
export function isLive(ms: number, lost: boolean): boolean {
  return !lost && ms < LIVE_MS && ms >= -AHEAD_MS;
}
