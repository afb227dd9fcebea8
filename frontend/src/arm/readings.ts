/** The newest state of an arm as a table. */
import { byId } from "../kit/dom.ts";
import { fill } from "../kit/render.ts";
import { gettext } from "../kit/text.ts";
import { worded } from "../page/plain_words.ts";
import type { StatePacket } from "../socket/packets.ts";
import { deg } from "./types.ts";

/** Show joints with their names, and the gripper in words. */
export function showReadings(axes: readonly string[], packet: StatePacket, gripper: string): void {
  const rows = axes.map((name, i) => {
    const v = packet.velocities[i],
      t = packet.torques[i];
    const angle = `${deg(packet.joints[i] ?? 0).toFixed(1)}°`;
    return [worded(name), angle, v === undefined ? "" : `${deg(v).toFixed(1)} °/s`, t === undefined ? "" : `${t.toFixed(1)} N m`];
  });
  fill(byId("readings").querySelector("tbody")!, [...rows, [gettext("Gripper"), worded(gripper), "", ""]]);
}
