/** The newest state of the robot: its values by the names of its spec, and whether it is still where a picture shows it. */
import type { StatePacket } from "../socket/packets.ts";
import { hasLeft, splitState, type Tolerance } from "../socket/poses.ts";
import { facts } from "./facts.ts";

const SILENT_MS = 3000;
const ALONE_MS = 1500; // messages sent together with the robot's last one do not count

export class RobotState {
  packet: StatePacket | null = null;
  private heardAt = 0;

  /** Compact states lack velocities and torques; unless `whole`, one between them must not show them for a moment. */
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
    return hasLeft(
      pose,
      this.pose,
      facts.pose.map(({ unit }) => unit),
      near,
    );
  }

  /** Whether the portal was heard after the robot's last message, which is old; without a connection nothing is known. */
  silent(now: number, heardSince: (at: number) => boolean): boolean {
    return this.packet !== null && now - this.packet.atMs > SILENT_MS && heardSince(this.heardAt + ALONE_MS);
  }
}
