/** Which of a person's places the turn bar shows. */
import type { QueuePlace } from "./person_socket.ts";

/** The places without offers that are past their end; the server sends the result within two seconds. */
export function currentPlaces(places: readonly QueuePlace[], now: number): QueuePlace[] {
  return places.filter((p) => !(p.state === "offered" && p.until_ms !== null && p.until_ms <= now));
}

/**
 * The places for the bar, the most urgent first. The page of the robot `own` shows a turn there itself, and how it
 * ended, but not that it ends soon because nothing is done.
 */
export function barPlaces(places: readonly QueuePlace[], own: string): QueuePlace[] {
  const hidden = (p: QueuePlace): boolean =>
    p.robot === own && ((p.state === "operating" && !p.idles) || (p.state === "ended" && p.turn !== null));
  return places.filter((p) => !hidden(p)).sort((a, b) => Number(b.idles ?? false) - Number(a.idles ?? false));
}
