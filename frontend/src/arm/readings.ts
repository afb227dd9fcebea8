/** The newest state of an arm as a table. */
import { byId } from "../kit/dom.ts";
import { fill } from "../kit/render.ts";
import { decimals, gettext } from "../kit/text.ts";
import { worded } from "../page/plain_words.ts";
import type { StatePacket } from "../socket/packets.ts";
import { deg } from "./types.ts";

/** Show joints with their names, and the gripper in words. */
export function showReadings(axes: readonly string[], packet: StatePacket, gripper: string): void {
  const rows = axes.map((name, i) => {
    const v = packet.velocities[i],
      t = packet.torques[i];
    const angle = `${decimals(deg(packet.joints[i] ?? 0), 1)}°`;
    return [worded(name), angle, v === undefined ? "" : `${decimals(deg(v), 1)} °/s`, t === undefined ? "" : `${decimals(t, 1)} N m`];
  });
  fill(byId("readings").querySelector("tbody")!, [...rows, [gettext("Gripper"), worded(gripper), "", ""]]);
}
