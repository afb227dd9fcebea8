/** Times in words. */
import { decimals, language } from "./text.ts";

/** Return a duration as minutes and seconds; never less than 0:00. */
export function clock(seconds: number): string {
  const s = Math.max(0, Math.ceil(seconds));
  return `${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}`;
}

/** Return an age (ms) in the unit that suits it. */
export function ago(ms: number): string {
  const s = ms / 1000;
  if (s < 10) return `${decimals(Math.max(0, s), 1)} s`;
  if (s < 90) return `${Math.round(s)} s`;
  if (s < 5400) return `${Math.round(s / 60)} min`;
  return `${Math.round(s / 3600)} h`;
}

/** Return a time (ms) by this browser's clock, with the day unless it is today. */
export function timeOfDay(ms: number, seconds = false): string {
  const at = new Date(ms),
    today = at.toDateString() === new Date().toDateString();
  const options: Intl.DateTimeFormatOptions = { hour: "2-digit", minute: "2-digit", hourCycle: "h23" };
  if (seconds) options.second = "2-digit";
  if (!today) Object.assign(options, { day: "numeric", month: "long", year: "numeric" });
  return new Intl.DateTimeFormat(language(), options).format(at);
}
