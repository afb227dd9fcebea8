/** Live pictures: which of a camera's is newer, how old one is in words, and which ones reduced motion skips. */
import { ago } from "../kit/times.ts";
import { gettext } from "../kit/text.ts";
import type { PicturePacket } from "../socket/packets.ts";

export const LIVE_MS = 5000; // an older picture does not show what is there now
const AHEAD_MS = 2000; // a stamp so far in the future says nothing: some clock is wrong
const CALM_MS = 10_000; // between two live pictures with reduced motion
const BACK_MS = 5000; // a picture that was taken so much earlier comes after the server's clock was set back

/** When a camera's picture on the page was taken (server ms), and the stored picture to which it belongs. */
export interface ShownPicture {
  atMs: number;
  stillId: number;
}

/** Return a picture's age in words, and its mark. `often`: how many come in a second; empty if that is not said. */
export function pictureAge(ms: number, often = ""): [words: string, mark: "fresh" | "ageing" | "old"] {
  if (ms < -AHEAD_MS) return [gettext("Picture of unknown age"), "old"];
  const age = ago(ms);
  const words = often ? gettext("Picture {age} old, {often} a second", { age, often }) : gettext("Picture {age} old", { age });
  return [words, ms < 2000 ? "fresh" : ms < LIVE_MS ? "ageing" : "old"];
}

/** Return whether a picture of that age shows what is there now; `lost`: the server is not reached. */
export function isLive(ms: number, lost: boolean): boolean {
  return !lost && ms < LIVE_MS && ms >= -AHEAD_MS;
}

/** Return whether a live picture is skipped because the person prefers reduced motion: one was shown a short time ago. */
export function skipsForReducedMotion(packet: Pick<PicturePacket, "atMs" | "still">, shown: ShownPicture): boolean {
  const fresh = packet.still !== 0 && packet.still !== shown.stillId;
  return !fresh && packet.atMs - shown.atMs < CALM_MS;
}

type Taken = Pick<PicturePacket, "atMs" | "number" | "first">;

/** The order of a camera's pictures by the time at which they were taken: numbers restart with the robot's process. */
export class PictureOrder {
  private newest: Taken | null = null;

  /** Take a picture. Returns whether it is newer than all before it. */
  take({ atMs, number, first }: Taken): boolean {
    const { newest } = this;
    const laterMs = newest ? atMs - newest.atMs : 0;
    const follows = !newest || first || laterMs > 0 || laterMs < -BACK_MS || (laterMs === 0 && number > newest.number);
    if (follows) this.newest = { atMs, number };
    return follows;
  }

  /** Return whether this picture is the newest. */
  holds(picture: Taken): boolean {
    return this.newest?.atMs === picture.atMs && this.newest.number === picture.number;
  }

  forget(): void {
    this.newest = null;
  }
}
