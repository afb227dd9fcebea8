/** What the parts of an arm's console share: the arm's description, targets, degrees. */
import type { Facts } from "../page/controls.ts";
import type { PlanAnswer } from "../socket/messages.ts";
import type { StatePacket } from "../socket/packets.ts";
import type { ForbiddenBox } from "./view.ts";
import { gettext } from "../kit/text.ts";

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
/** The judge of targets: it asks the server where one would lead, and says why one cannot be sent. */
export interface Judge {
  ask(): void;
  whyNot(kind: string, facts: Facts): string;
}

/** A mode of control: `asked` is the kind of its command, `checked` gets the server's answer instead of the ghost. */
export interface ArmMode {
  asked: string;
  /** Why nothing can be sent where there is no target. */
  empty?: string;
  target(): Target | null;
  /** Return why a value is out of its range, in the words of its field; empty if none is. */
  outside?(): string;
  open?(): void;
  state?(packet: StatePacket): void;
  /** Tell what becomes of its command; called again and again. */
  tellRun?(): void;
  checked?(answer: PlanAnswer): void;
  /** Judge the target in the page: return why it cannot be sent, empty if it can. Then the server is not asked before. */
  local?(): string;
  /** Judge again: the arm has moved, or the speed is another. For modes with `local`. */
  again?(): void;
}

/** What an arm has beside its joints: which joints of the model follow a further number of its posture, and its gripper. */
export interface ArmParts {
  moved: string[][];
  /** Return the numbers that move the model: the joints, then one for each of `moved`. */
  posture(packet: StatePacket): number[];
  /** Return what is known of the gripper, in words. */
  gripper(packet: StatePacket): string;
}

export function deg(radians: number): number {
  return (radians * 180) / Math.PI;
}

export function rad(degrees: number): number {
  return (degrees * Math.PI) / 180;
}

/** Return why a field's value is refused, empty if it is not; `per`: how many of the field's unit make the argument's. */
export function rangeError(name: string, value: number, unit: string, per: number, { low, high }: { low: number; high: number }): string {
  const bound = (told: number): string => String(Math.round(told * per * 10) / 10);
  const inside = value >= low * per && value <= high * per;
  return inside ? "" : gettext("{name} must lie between {low} and {high} {unit}.", { name, low: bound(low), high: bound(high), unit });
}

/** Whether somebody has filled in a target: fields without one show where the arm is. */
export class TargetEdit {
  private after = -1; // the number of the newest command at the last edit; -1: nothing is filled in

  get now(): boolean {
    return this.after >= 0;
  }

  /** Note that somebody has filled in something; `seq`: the number of the newest command. */
  note(seq: number): void {
    this.after = seq;
  }

  /** Forget what was filled in before the command of that number, which has moved the arm. */
  arrived(seq: number): void {
    if (this.after < seq) this.after = -1;
  }

  forget(): void {
    this.after = -1;
  }
}
/** What the server says of a target, which `key` names: whether it can be reached, and why not. */
export interface Plan {
  key: string;
  ok: boolean;
  text: string;
}
