/** Where the robot is and was: packets contain numbers in a row, which the spec divides into parts. */
import type { PicturePacket, StatePacket } from "./packets.ts";

/** Divide the numbers of a picture into joints, pose and, with the rest, the body's velocity. `joints`, `pose`: how many. */
export function splitPicture(packet: PicturePacket, joints: number, pose: number): PicturePacket {
  const told = packet.joints;
  return { ...packet, joints: told.slice(0, joints), pose: told.slice(joints, joints + pose), twist: told.slice(joints + pose) };
}

/** Divide the numbers of a state into so many values and, with the rest, the body's velocity. */
export function splitState(packet: StatePacket, values: number): StatePacket {
  return { ...packet, values: packet.values.slice(0, values), twist: packet.values.slice(values) };
}

/** Return poses of the robot's own frame in the frame of its pose `here`; all have x, y, heading (m, rad). */
export function fromOwn(here: readonly number[], poses: readonly (readonly number[])[]): number[][] {
  const [x = NaN, y = NaN, heading = NaN] = here,
    c = Math.cos(heading),
    s = Math.sin(heading);
  return poses.map(([ahead = NaN, aside = NaN, turned = NaN]) => [x + c * ahead - s * aside, y + s * ahead + c * aside, heading + turned]);
}

/** How far a robot may be from the place of a picture without having left it. */
export interface Tolerance {
  m: number;
  rad: number;
}
const DEFAULT_TOLERANCE: Tolerance = { m: 0.02, rad: 0.05 };

/**
 * Return whether the robot has left the pose `then`, by coordinates in the order of its spec; no if either pose is not
 * known. Two angles differ by half a turn at most.
 */
export function hasLeft(
  then: readonly number[],
  now: readonly number[],
  units: readonly string[],
  near: Tolerance = DEFAULT_TOLERANCE,
): boolean {
  if (then.length !== units.length || now.length !== units.length) return false;
  const m = Math.hypot(...then.map((v, i) => (units[i] === "m" ? now[i]! - v : 0)));
  const turned = then.map((v, i) => (units[i] === "m" ? 0 : Math.abs(Math.atan2(Math.sin(now[i]! - v), Math.cos(now[i]! - v)))));
  return m > near.m || turned.some((rad) => rad > near.rad);
}
