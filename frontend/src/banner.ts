/** What the banner over a robot's page says: the truth about the connection first, for only with it is more known. */
import type { Snapshot } from "./protocol.ts";

export interface Known {
  /** Whether nothing reaches the portal, and for how long it has been so (ms). */
  lost: boolean;
  lostMs: number;
  /** Whether the browser itself says that the device is offline. */
  offline: boolean;
  /** Whether the portal was heard while the robot said nothing. */
  robotSilent: boolean;
  stopPending: string;
  storeDown: string;
  snapshot: Snapshot | null;
}

const AT_ONCE_MS = 1000; // shorter gaps are nobody's concern

export function bannerWords(k: Known): string {
  if (k.lost && (k.lostMs > AT_ONCE_MS || k.stopPending)) {
    const why = k.offline ? "this device is offline" : "the portal is not reached";
    const turn = k.snapshot?.me.can.drive ? " Your turn is kept for 20 s." : "";
    return `Connection lost: ${why}. ${k.stopPending || `It is tried again by itself.${turn}`}`;
  }
  if (k.lost) return "";
  if (k.stopPending) return k.stopPending;
  if (k.snapshot && !k.snapshot.link) return "The live link to the robots is down. Pages work; nothing moves until it is back.";
  if (k.storeDown) return k.storeDown;
  return k.robotSilent ? "The robot does not answer. What looks after it is started again by itself; turns and places are kept." : "";
}
