/** The operator's controls: enabled, or saying why not. */
import type { Snapshot, StatePacket } from "./protocol.ts";

export interface Facts {
  snapshot: Snapshot | null; state: StatePacket | null; lineUp: boolean; now: number; latency: number | null;
  busy: boolean; aim: "none" | "good" | "refused" | "old";
}

/** Why nothing can be commanded now; empty when something can. */
export function blocked(f: Facts): string {
  const s = f.snapshot;
  if (!f.lineUp || !s) return "The connection is gone; it is being tried again. Your turn is kept for 20 seconds.";
  if (!s.link) return "The live link to the robot is down; nothing moves until it is back. Your turn is kept.";
  if (!s.me.operating) return "It is not your turn.";
  if (s.robot.state === "fault") return `The robot has a fault: ${s.robot.why}`;
  if (s.robot.state === "offline") return s.robot.why;
  if (s.stopped || f.state?.stopped) return "Stopped. Look at the picture, then release the stop.";
  const limit = Math.min(3000, 1000 + 2 * (f.latency ?? 0));
  if (!f.state || f.now - f.state.atMs > limit) return "The robot's state is not known right now; waiting for it.";
  return "";
}

const DOWN_M = 0.001;

/** Why one control will not work now; empty when it will. */
export function whyNot(kind: string, f: Facts): string {
  const general = blocked(f);
  if (general) return general;
  if (f.busy) return "One command at a time: the arm is still busy.";
  const z = f.state?.joints[2] ?? 0;
  if (kind === "air" && z > DOWN_M) return "Air works only at Z = 0: press Down first.";
  if (kind === "down" && z <= DOWN_M) return "The arm is down already.";
  if (kind === "up" && z >= 0.0745) return "The arm is up already.";
  if (kind === "go" && f.aim === "none") return "Click in the camera image or in the map to choose where to go.";
  if (kind === "go" && f.aim === "refused") return "The arm may not go there: it is off the sand.";
  if (kind === "go" && f.aim === "old") return "The arm has moved since that picture; click in the newest one.";
  return "";
}
