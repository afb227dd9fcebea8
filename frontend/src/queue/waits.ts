/** How many people wait and watch, and how long a person waits, in words. */

/** Return how many people watch, without the driver, in words; `driving`: whether the reader drives. */
export function watcherWords(count: number, driving: boolean): string {
  const others = driving ? count : Math.max(0, count - 1);
  if (driving) return others === 0 ? "nobody else watches" : others === 1 ? "1 other watches" : `${others} others watch`;
  return others === 0 ? "only you watch" : others === 1 ? "you and 1 other watch" : `you and ${others} others watch`;
}

/** Return the expected wait (s, least and greatest; null: not known) in words. */
export function waitWords(wait: readonly [number, number] | null): string {
  if (wait === null) return "the wait is not known now";
  const [low, high] = wait;
  if (high < 10) return "any moment now";
  if (high < 60) return "less than a minute";
  const far = rounded(high);
  return low < 60 ? `at most ${far}` : rounded(low) === far ? `about ${far}` : `about ${rounded(low)} to ${far}`;
}

/** Return the expected wait as a sentence. */
export function waitSentence(wait: readonly [number, number] | null): string {
  const words = waitWords(wait);
  return wait === null ? "The wait is not known now; your place is kept." : `${words.charAt(0).toUpperCase()}${words.slice(1)}.`;
}

const CLOSED = ["fault", "stopped", "offline", "locked_out"]; // nobody knows when a turn begins

/** Return how long somebody who joins now would wait; empty where nobody knows. */
export function joinWait(state: string, free: boolean, wait: readonly [number, number] | null): string {
  if (CLOSED.includes(state)) return "";
  return free ? "Free now" : `Your wait: ${wait ? waitWords(wait) : "not known now"}`;
}

/** Return how many requests wait, of people and for jobs. */
export function queueSentence(count: number): string {
  return count === 0 ? "Nobody waits." : `${count} in the queue.`;
}

/** What is said of a robot's jobs after a stop. */
export const SUSPENDED = "Jobs and the robot's own behaviour wait until staff press Resume jobs.";

/** Return the state of the viewer's waiting job, with `ahead` requests before it. */
export function jobSentence(noun: string, ahead: number, wait: readonly [number, number] | null, suspended: boolean): string {
  if (suspended) return `Your ${noun} keeps its place. ${SUSPENDED}`;
  const before = ahead === 0 ? "It is next" : ahead === 1 ? "One is before it" : `${ahead} are before it`;
  return `Your ${noun} waits. ${before}; ${waitWords(wait)}.`;
}

function rounded(seconds: number): string {
  return seconds < 5400 ? `${Math.ceil(seconds / 60)} min` : `${Math.ceil(seconds / 3600)} h`;
}
