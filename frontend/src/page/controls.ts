/** Whether anything can be commanded now, on any robot. */
import { unconfirmed } from "./banner.ts";
import type { PicturePacket, Snapshot, StatePacket } from "../socket/protocol.ts";

export interface Facts {
  snapshot: Snapshot | null; state: StatePacket | null; lineUp: boolean; now: number; latency: number | null;
  busy: boolean;
}

/** Why nothing can be commanded now; empty when something can. */
export function blocked(f: Facts): string {
  const s = f.snapshot;
  if (!f.lineUp || !s) return "The connection is lost; the page tries to connect again. Your turn is kept for 20 seconds.";
  if (s.replay) return "This is a recording.";
  if (!s.link) return "The live link to the robot is down; nothing moves until it is back. Your turn is kept.";
  if (!s.me.can.drive) return s.robot.turns === false ? "Nobody drives this robot; everybody can ask it for a job." : notOperating(s.me);
  if (s.robot.state === "fault") return `The robot has a fault: ${s.robot.why}`;
  if (s.robot.state === "offline") return s.robot.why;
  if (s.stopped || f.state?.stopped) return `${unconfirmed(s.stop, f.now) ? "Stop is pressed" : "Stopped"}. Look at the picture, then release the stop.`;
  const limit = Math.min(3000, 1000 + 2 * (f.latency ?? 0));
  if (!f.state || f.now - f.state.atMs > limit) return "The robot's state is not known right now; waiting for it.";
  return "";
}

function notOperating(me: Snapshot["me"]): string {
  if (me.ticket?.state === "offered") return "It is your turn: take control to begin.";
  if (me.ticket?.state === "waiting") return "You wait for your turn.";
  return me.cleared ? "Join the queue to operate the robot." : "You can watch. To operate, read the orientation and pass the test.";
}

/** When a camera's picture on the page was taken (server ms), and the stored picture to which it belongs. */
export interface Shown { atMs: number; stillId: number }
const CALM_MS = 10_000;

/** Whether a live picture is skipped because the person prefers reduced motion: one was shown a short time ago. */
export function tooLively(packet: Pick<PicturePacket, "atMs" | "still">, shown: Shown): boolean {
  const fresh = packet.still !== 0 && packet.still !== shown.stillId;
  return !fresh && packet.atMs - shown.atMs < CALM_MS;
}
