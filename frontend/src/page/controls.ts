/** Whether anything can be commanded now, on any robot. */
import type { Snapshot } from "../socket/messages.ts";
import type { StatePacket } from "../socket/packets.ts";
import { unconfirmedStop } from "./banner.ts";
import { gettext, translate } from "../kit/text.ts";

export interface Facts {
  snapshot: Snapshot | null;
  state: StatePacket | null;
  lineUp: boolean;
  now: number;
  latency: number | null;
  busy: boolean;
}

/** Return why nothing can be commanded now; empty if something can. */
export function blocked(f: Facts): string {
  const s = f.snapshot;
  if (!f.lineUp || !s) return gettext("The connection is lost; the page tries to connect again. Your turn is kept for 20 seconds.");
  if (s.replay) return gettext("This is a recording.");
  if (!s.link) return gettext("The live link to the robot is down; nothing moves until it is back. Your turn is kept.");
  if (!s.me.can.drive) return s.robot.turns ? notOperating(s.me) : gettext("Nobody drives this robot; everybody can ask it for a job.");
  if (s.robot.state === "fault") return gettext("The robot has a fault: {why}", { why: translate(s.robot.why) });
  if (s.robot.state === "offline") return translate(s.robot.why);
  if (s.stopped || f.state?.stopped)
    return unconfirmedStop(s.stop, f.now)
      ? gettext("Stop is pressed. Look at the picture, then release the stop.")
      : gettext("Stopped. Look at the picture, then release the stop.");
  const limit = Math.min(3000, 1000 + 2 * (f.latency ?? 0));
  if (!f.state || f.now - f.state.atMs > limit) return gettext("The robot's state is not known right now; waiting for it.");
  return "";
}

function notOperating(me: Snapshot["me"]): string {
  if (me.ticket?.state === "offered") return gettext("It is your turn: take control to begin.");
  if (me.ticket?.state === "waiting") return gettext("You wait for your turn.");
  if (me.cleared) return gettext("Join the queue to operate the robot.");
  return me.read
    ? gettext("You can watch. To operate, pass the test.")
    : gettext("You can watch. To operate, read the orientation and pass the test.");
}
