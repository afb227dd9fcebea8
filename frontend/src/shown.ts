/** Which of a person's places the turn bar shows. */
import type { Standing } from "./person.ts";

/** The places without offers that are past their end; the server sends the result within two seconds. */
export function current(places: readonly Standing[], now: number): Standing[] {
  return places.filter((p) => !(p.state === "offered" && p.until_ms !== null && p.until_ms <= now));
}

/** The places for the bar, the most urgent first; the page of the robot `own` shows a turn there itself. */
export function shownOf(places: readonly Standing[], own: string): Standing[] {
  return places.filter((p) => !(p.robot === own && p.state === "operating"));
}
