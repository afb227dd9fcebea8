/** The values of the museum arm's joints and gripper, for people. */
import { deg } from "/static/farhand/v1/arm.js";
import { byId, fill, type StatePacket } from "/static/farhand/v1/console.js";

/** Show the newest state in the table of readings; `joints` are the names of the joints, in their order. */
export function showReadings(packet: StatePacket, joints: readonly string[]): void {
  const rows = [...joints, "Gripper"].map((name, i) => {
    const last = i === joints.length;
    const q = packet.joints[i] ?? 0,
      v = packet.velocities[i],
      t = packet.torques[i];
    return last
      ? [name, `${(q * 1000).toFixed(0)} mm`, "", ""]
      : [name, `${deg(q).toFixed(1)}°`, v === undefined ? "" : `${deg(v).toFixed(1)} °/s`, t === undefined ? "" : `${t.toFixed(1)} N m`];
  });
  fill(byId("readings").querySelector("tbody")!, rows);
}
