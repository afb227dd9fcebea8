/** Which live pictures are shown to people who prefer reduced motion. */
import type { PicturePacket } from "../socket/packets.ts";

/** When a camera's picture on the page was taken (server ms), and the stored picture to which it belongs. */
export interface ShownPicture {
  atMs: number;
  stillId: number;
}
const CALM_MS = 10_000;

/** Whether a live picture is skipped because the person prefers reduced motion: one was shown a short time ago. */
export function skipsForReducedMotion(packet: Pick<PicturePacket, "atMs" | "still">, shown: ShownPicture): boolean {
  const fresh = packet.still !== 0 && packet.still !== shown.stillId;
  return !fresh && packet.atMs - shown.atMs < CALM_MS;
}
