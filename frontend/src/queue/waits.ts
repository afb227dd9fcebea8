/** How many people wait and watch, and how long a person waits, in words. */
import { gettext, ngettext } from "../kit/text.ts";

/** Return how many people watch, without the driver, in words; `driving`: whether the reader drives. */
export function watcherWords(count: number, driving: boolean): string {
  const others = driving ? count : Math.max(0, count - 1);
  if (driving) return others === 0 ? gettext("nobody else watches") : ngettext("{count} other watches", "{count} others watch", others);
  return others === 0 ? gettext("only you watch") : ngettext("you and {count} other watch", "you and {count} others watch", others);
}

/** Return the expected wait (s, least and greatest; null: not known) in words. */
export function waitWords(wait: readonly [number, number] | null): string {
  if (wait === null) return gettext("the wait is not known now");
  const [low, high] = wait;
  if (high < 10) return gettext("any moment now");
  if (high < 60) return gettext("less than a minute");
  const far = rounded(high);
  if (low < 60) return gettext("at most {time}", { time: far });
  const near = rounded(low);
  return near === far ? gettext("about {time}", { time: far }) : gettext("about {near} to {far}", { near, far });
}

/** Return the expected wait as a sentence. */
export function waitSentence(wait: readonly [number, number] | null): string {
  const words = waitWords(wait);
  return wait === null ? gettext("The wait is not known now; your place is kept.") : `${words.charAt(0).toUpperCase()}${words.slice(1)}.`;
}

const CLOSED = ["fault", "stopped", "offline", "locked_out"]; // nobody knows when a turn begins

/** Return how long somebody who joins now would wait; empty where nobody knows. */
export function joinWait(state: string, free: boolean, wait: readonly [number, number] | null): string {
  if (CLOSED.includes(state)) return "";
  if (free) return gettext("Free now");
  return wait ? gettext("Your wait: {wait}", { wait: waitWords(wait) }) : gettext("Your wait: not known now");
}

/** Return how many requests wait, of people and for jobs. */
export function queueSentence(count: number): string {
  return count === 0 ? gettext("Nobody waits.") : ngettext("{count} in the queue.", "{count} in the queue.", count);
}

/** Return how many are before the reader. */
export function before(count: number): string {
  return ngettext("{count} before you", "{count} before you", count);
}

/** What is said of a robot's jobs after a stop. */
export const SUSPENDED = gettext("Jobs and the robot's own behaviour wait until staff press Resume jobs.");

/** Return the state of the viewer's waiting job, with `ahead` requests before it. `noun`: what the robot calls it. */
export function jobSentence(noun: string, ahead: number, wait: readonly [number, number] | null, suspended: boolean): string {
  if (suspended) return `${gettext("Your {noun} keeps its place.", { noun })} ${SUSPENDED}`;
  const values = { wait: waitWords(wait) };
  const place =
    ahead === 0
      ? gettext("It is next; {wait}.", values)
      : ngettext("One is before it; {wait}.", "{count} are before it; {wait}.", ahead, values);
  return `${gettext("Your {noun} waits.", { noun })} ${place}`;
}

function rounded(seconds: number): string {
  return seconds < 5400 ? `${Math.ceil(seconds / 60)} min` : `${Math.ceil(seconds / 3600)} h`;
}
