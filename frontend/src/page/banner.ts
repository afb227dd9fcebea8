/** The text of the banner on a robot's page: the connection first, because without it nothing else is known. */
import { byId, say } from "../kit/dom.ts";
import { timeOfDay } from "../kit/times.ts";
import { gettext, translate } from "../kit/text.ts";
import type { Snapshot, StopShown } from "../socket/messages.ts";

export interface BannerFacts {
  /** Whether the portal is not reached, and for how long (ms). */
  lost: boolean;
  lostMs: number;
  /** Whether the browser itself says that the device is offline. */
  offline: boolean;
  /** Whether the portal was heard while the robot said nothing. */
  robotSilent: boolean;
  stopPending: string;
  storeDown: string;
  snapshot: Snapshot | null;
  /** The portal's time (ms). */
  now: number;
}

const AT_ONCE_MS = 1000; // shorter gaps are not shown
const CONFIRMED_MS = 1000; // a missing confirmation is shown after this time

/** Return the text for a stop that the robot has not confirmed; empty if there is none, or only for a short time. */
export function unconfirmedStop(stop: StopShown | null, now: number): string {
  if (!stop || stop.confirmed || (stop.rests_by_ms === null && now - (stop.since_ms ?? 0) < CONFIRMED_MS)) return "";
  if (stop.rests_by_ms === null)
    return gettext("Stop is pressed, but the robot has not confirmed that it rests. When it will is not known: do not rely on it.");
  const at = timeOfDay(stop.rests_by_ms, true);
  if (now >= stop.rests_by_ms)
    return gettext(
      "Stop is pressed, but the robot has not confirmed that it rests. Without a connection it stops by itself, and should rest since {at}. Look at the picture.",
      { at },
    );
  return gettext(
    "Stop is pressed, but the robot has not confirmed that it rests. Without a connection it stops by itself, at {at} at the latest.",
    { at },
  );
}

/** Return the text of the banner; empty if all is well. */
export function bannerWords(k: BannerFacts): string {
  if (k.lost && (k.lostMs > AT_ONCE_MS || k.stopPending)) {
    const why = k.offline ? gettext("Connection lost: this device is offline.") : gettext("Connection lost: the portal is not reached.");
    const then = k.snapshot?.me.can.drive
      ? gettext("The page connects again automatically. Your turn is kept for 20 s.")
      : gettext("The page connects again automatically.");
    return `${why} ${k.stopPending || then}`;
  }
  if (k.lost) return "";
  if (k.stopPending) return k.stopPending;
  const still = unconfirmedStop(k.snapshot?.stop ?? null, k.now);
  if (still) return still;
  if (k.snapshot && !k.snapshot.link) return gettext("The live link to the robots is down. Pages work; nothing moves until it is back.");
  if (k.storeDown) return translate(k.storeDown);
  return k.robotSilent ? gettext("The robot does not answer. Its worker is restarted automatically. Turns and places are kept.") : "";
}

/** Show the banner, or hide it for an empty text; `appears` is called before it is shown. */
export function showBanner(words: string, appears: () => void): void {
  const box = byId("banner");
  if (words && !box.textContent) appears();
  say(box, words);
  box.hidden = !words;
}
