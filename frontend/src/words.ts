/** Times and stages in words. */
import type { CommandInfo } from "./protocol.ts";

export function clock(seconds: number): string {
  const s = Math.max(0, Math.ceil(seconds));
  return `${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}`;
}

export function ago(ms: number): string {
  const s = ms / 1000;
  if (s < 10) return `${Math.max(0, s).toFixed(1)} s`;
  if (s < 90) return `${Math.round(s)} s`;
  if (s < 5400) return `${Math.round(s / 60)} min`;
  return `${Math.round(s / 3600)} h`;
}

export const LIVE_MS = 5000; // an older picture does not show what is there now
const AHEAD_MS = 2000; // a stamp so far in the future says nothing: some clock is wrong

/** A picture's age in words, and how it is marked; `often`: how many a second come, in words. */
export function pictureAge(ms: number, often = ""): [words: string, mark: "fresh" | "ageing" | "old"] {
  if (ms < -AHEAD_MS) return ["Picture of unknown age", "old"];
  return [`Picture ${ago(ms)} old${often}`, ms < 2000 ? "fresh" : ms < LIVE_MS ? "ageing" : "old"];
}

/** Whether a picture of that age shows what is there now; `lost`: the server is not reached. */
export function shownLive(ms: number, lost: boolean): boolean {
  return !lost && ms < LIVE_MS && ms >= -AHEAD_MS;
}

/** How many people watch, the driver apart, in words; `driving`: the person who reads it drives. */
export function watcherWords(count: number, driving: boolean): string {
  const others = driving ? count : Math.max(0, count - 1);
  if (driving) return others === 0 ? "nobody else watches" : others === 1 ? "1 other watches" : `${others} others watch`;
  return others === 0 ? "only you watch" : others === 1 ? "you and 1 other watch" : `you and ${others} others watch`;
}

/** The expected wait in words; null where nobody knows. */
export function waitWords(wait: readonly [number, number] | null): string {
  if (wait === null) return "the wait is not known now";
  const [low, high] = wait;
  if (high < 10) return "any moment now";
  if (high < 60) return "less than a minute";
  const far = rounded(high);
  return low < 60 ? `at most ${far}` : rounded(low) === far ? `about ${far}` : `about ${rounded(low)} to ${far}`;
}

/** How long one waits, as a sentence. */
export function waitSaid(wait: readonly [number, number] | null): string {
  const words = waitWords(wait);
  return wait === null ? "The wait is not known now; your place is kept." : `${words.charAt(0).toUpperCase()}${words.slice(1)}.`;
}

/** How many requests wait, of people and for jobs. */
export function waitingSaid(count: number): string {
  return count === 0 ? "Nobody waits." : `${count} in the queue.`;
}

/** When something was, by this browser's clock: the time, and the day unless it is today. */
export function timeSaid(ms: number): string {
  const at = new Date(ms), time = at.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
  return at.toDateString() === new Date().toDateString() ? time : `${at.toLocaleDateString()} ${time}`;
}

/** Jobs of a robot after a stop. */
export const SUSPENDED = "Jobs and the robot's own behaviour wait until staff press Resume jobs.";

/** How a job of the viewer's stands that waits, with so many requests before it. */
export function standing(noun: string, ahead: number, wait: readonly [number, number] | null, suspended: boolean): string {
  if (suspended) return `Your ${noun} keeps its place. ${SUSPENDED}`;
  const before = ahead === 0 ? "It is next" : ahead === 1 ? "One is before it" : `${ahead} are before it`;
  return `Your ${noun} waits. ${before}; ${waitWords(wait)}.`;
}

function rounded(seconds: number): string {
  return seconds < 5400 ? `${Math.ceil(seconds / 60)} min` : `${Math.ceil(seconds / 3600)} h`;
}

export const STAGES: Record<string, string> = {
  sending: "Sending", queued: "Queued", accepted: "Accepted", sent: "Sent to the robot", acknowledged: "Moving",
  completed: "Settled", rejected: "Refused", failed: "Failed", expired: "Too late", cancelled: "Stopped", unknown: "Unknown",
};
/** Labels of commands, and which of them set something and move nothing: the robot's page tells them. */
export const KINDS: Record<string, string> = {};
export const SETTINGS = new Set<string>();
/** How far a command is, in a word. */
export function stageOf(kind: string, state: string): string {
  if (SETTINGS.has(kind) && state === "acknowledged") return "Under way";
  if (SETTINGS.has(kind) && state === "completed") return "Done";
  return STAGES[state] ?? state;
}
export const FINAL = new Set(["completed", "rejected", "failed", "expired", "cancelled", "unknown"]);

/** What a page shows of a command after a snapshot, which may have been read before the command ended. */
export function latest(known: CommandInfo | undefined, read: CommandInfo): CommandInfo {
  return known && known.id === read.id && FINAL.has(known.state) && !FINAL.has(read.state) ? known : read;
}
