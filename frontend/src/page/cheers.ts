/** Cheers for who drives: the button of watchers, how many there are, and the driver's choice to see none of it. */
import { byId, say } from "../kit/dom.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { storage } from "../kit/storage.ts";
import { gettext, ngettext } from "../kit/text.ts";
import type { CheerCount, Snapshot } from "../socket/messages.ts";

const PAUSE_MS = 5000; // between two cheers of a page; the portal counts no more
const HEARD_MS = 10_000; // between two times that a screen reader is told
const MOST = 999; // so that the words stay short
const AGAIN = gettext("You have cheered. You can again in a few seconds.");
const KEY = "cheers"; // in the browser's storage: "off" where a driver wants to see none

/** Return how many have cheered, in words; empty for none. */
export function cheerWords(count: number): string {
  if (count === 0) return "";
  return count > MOST ? gettext("over {most} cheers", { most: MOST }) : ngettext("{count} cheer", "{count} cheers", count);
}

/** The part of the page that `Cheers` needs. */
interface CheerUse {
  /** Show why something is refused, for as long as `why` returns the same. */
  refuse(why: () => string): void;
}

export class Cheers {
  private button = byId<HTMLButtonElement>("cheer");
  private choice = byId("cheers-choice");
  private shown = byId<HTMLInputElement>("cheers-shown");
  private calm = matchMedia("(prefers-reduced-motion: reduce)");
  private newest: CheerCount | null = null;
  private drawn = 0; // cheers on the page
  private pressedAt = -Infinity;
  private heardAt = -Infinity;

  /** `send` sends a cheer. */
  constructor(send: () => void, use: CheerUse) {
    this.shown.checked = storage.get(KEY) !== "off";
    this.shown.addEventListener("change", () => storage.set(KEY, this.shown.checked ? "on" : "off"));
    this.button.addEventListener("click", () => {
      if (refusal(this.button)) {
        use.refuse(() => refusal(this.button));
        return;
      }
      this.pressedAt = performance.now();
      allow(this.button, AGAIN);
      send();
    });
  }

  /** Take the newest count. */
  take(count: CheerCount): void {
    this.newest = count;
  }

  /** Take the answer to a cheer. */
  answer(ok: boolean): void {
    say(byId("cheer-said"), ok ? gettext("You cheered.") : "");
  }

  draw(s: Snapshot, lineUp: boolean): void {
    const drives = s.me.can.drive,
      rests = performance.now() - this.pressedAt >= PAUSE_MS;
    this.button.hidden = drives;
    this.choice.hidden = !drives;
    allow(this.button, whyNot(s, lineUp) || (rests ? "" : AGAIN));
    if (rests) say(byId("cheer-said"), "");
    const counts = this.newest?.grant === s.turn?.grant && s.turn?.cheers && (!drives || this.shown.checked);
    this.show(counts ? (this.newest?.count ?? 0) : 0);
  }

  private show(count: number): void {
    const words = cheerWords(count),
      place = byId("cheers");
    say(place, words && `, ${words}`);
    if (count > this.drawn && !this.calm.matches) place.animate([{ opacity: 0.2 }, { opacity: 1 }], 400);
    this.drawn = count;
    const heard = byId("cheers-heard"),
      now = performance.now();
    if (!words) say(heard, "");
    else if (heard.textContent !== `${words}.` && now - this.heardAt >= HEARD_MS) {
      say(heard, `${words}.`);
      this.heardAt = now;
    }
  }
}

/** Return why nobody can be cheered now; empty if somebody can. */
function whyNot(s: Snapshot, lineUp: boolean): string {
  if (!lineUp) return gettext("The connection is lost; a cheer would not arrive.");
  if (!s.turn) return gettext("Nobody drives now who could be cheered.");
  return s.turn.cheers ? "" : gettext("Staff have switched cheering off for this robot.");
}
