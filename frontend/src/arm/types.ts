/** Types that the parts of the arm's console share. */
import type { Facts } from "../page/controls.ts";
import type { ForbiddenBox } from "./view.ts";

export interface JointInfo {
  name: string;
  low: number;
  high: number;
  velocity: number;
}
export interface ArmDescription {
  model: string;
  joints: JointInfo[];
  boxes: ForbiddenBox[];
  tip: string;
}
/** A target as the driver knows it: a command and its values in SI units. */
export interface Target {
  kind: string;
  args: Record<string, number | string>;
}
/** Checks targets: asks the server where one would lead, and says why one cannot be sent. */
export interface Judge {
  ask(): void;
  whyNot(kind: string, facts: Facts): string;
}

export function deg(radians: number): number {
  return (radians * 180) / Math.PI;
}

export function rad(degrees: number): number {
  return (degrees * Math.PI) / 180;
}

/** Why a field's value cannot be given, in the field's own unit, of which the argument's has so many; empty if it can. */
export function rangeError(name: string, value: number, unit: string, per: number, { low, high }: { low: number; high: number }): string {
  const bound = (told: number): string => String(Math.round(told * per * 10) / 10);
  const inside = value >= low * per && value <= high * per;
  return inside ? "" : `${name} must lie between ${bound(low)} and ${bound(high)} ${unit}.`;
}
