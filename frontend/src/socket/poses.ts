/** Where the robot is and was: packets tell numbers in a row, which its spec divides. */
import type { PicturePacket, StatePacket } from "./packets.ts";

/** A picture whose robot has so many joints and coordinates of a pose, each apart; the body's velocity is what follows. */
export function splitPicture(packet: PicturePacket, joints: number, pose: number): PicturePacket {
  const told = packet.joints;
  return { ...packet, joints: told.slice(0, joints), pose: told.slice(joints, joints + pose), twist: told.slice(joints + pose) };
}

/** A state with so many values of channels and coordinates; the body's velocity is what follows. */
export function splitState(packet: StatePacket, values: number): StatePacket {
  return { ...packet, values: packet.values.slice(0, values), twist: packet.values.slice(values) };
}

/** Poses in the own frame of a robot that is at `here`, in the frame of that pose; both x, y, heading (m, rad). */
export function fromOwn(here: readonly number[], poses: readonly (readonly number[])[]): number[][] {
  const [x = NaN, y = NaN, heading = NaN] = here,
    c = Math.cos(heading),
    s = Math.sin(heading);
  return poses.map(([ahead = NaN, aside = NaN, turned = NaN]) => [x + c * ahead - s * aside, y + s * ahead + c * aside, heading + turned]);
}

/** How far a robot may be from where a picture shows it, for the picture to hold. */
export interface Tolerance {
  m: number;
  rad: number;
}
export const DEFAULT_TOLERANCE: Tolerance = { m: 0.02, rad: 0.05 };

/**
 * Whether the robot has left the place `then`, by coordinates in the order of its spec; no if either is not known.
 * Half a turn is the most by which two angles differ.
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
