/** The newest state of the robot: its values by the names of the spec, and whether it has left the place of a picture. */
import type { StatePacket } from "../socket/packets.ts";
import { hasLeft, splitState, type Tolerance } from "../socket/poses.ts";
import { facts } from "./facts.ts";

const SILENT_MS = 3000;
const ALONE_MS = 1500; // messages sent together with the robot's last one do not count

export class RobotState {
  packet: StatePacket | null = null;
  private heardAt = 0;

  /** Take a state. Without `whole` its velocities are left out, because the compact states before and after have none. */
  take(received: StatePacket, whole: boolean): StatePacket {
    const packet = splitState(received, facts.channels.length + facts.pose.length);
    this.packet = whole ? packet : { ...packet, velocities: [], torques: [], twist: [] };
    this.heardAt = performance.now();
    return this.packet;
  }

  value(name: string): number | undefined {
    const joint = facts.names.indexOf(name),
      channel = [...facts.channels, ...facts.pose].findIndex((c) => c.name === name);
    const value = joint < 0 ? this.packet?.values[channel] : this.packet?.joints[joint];
    return Number.isNaN(value) ? undefined : value;
  }

  get pose(): number[] {
    const first = facts.channels.length;
    return this.packet?.values.slice(first, first + facts.pose.length) ?? [];
  }

  hasLeft(pose: readonly number[], near?: Tolerance): boolean {
    const units = facts.pose.map(({ unit }) => unit);
    return hasLeft(pose, this.pose, units, near);
  }

  /** Return whether the robot's last message is old although the portal was heard later; no without a connection. */
  silent(now: number, heardSince: (at: number) => boolean): boolean {
    return this.packet !== null && now - this.packet.atMs > SILENT_MS && heardSince(this.heardAt + ALONE_MS);
  }
}
