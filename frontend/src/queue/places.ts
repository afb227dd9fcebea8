/** Which of a person's places the turn bar shows. */
import type { Standing } from "./person_socket.ts";

/** The places without offers that are past their end; the server sends the result within two seconds. */
export function current(places: readonly Standing[], now: number): Standing[] {
  return places.filter((p) => !(p.state === "offered" && p.until_ms !== null && p.until_ms <= now));
}

/**
 * The places for the bar, the most urgent first. The page of the robot `own` shows a turn there itself, and how it
 * ended, but not that it ends soon because nothing is done.
 */
export function shownOf(places: readonly Standing[], own: string): Standing[] {
  const hidden = (p: Standing): boolean =>
    p.robot === own && ((p.state === "operating" && !p.idles) || (p.state === "ended" && p.turn !== null));
  return places.filter((p) => !hidden(p)).sort((a, b) => Number(b.idles ?? false) - Number(a.idles ?? false));
}
