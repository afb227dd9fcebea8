/** The one interface of everything that moves the ghost of a tool: handles, keys, finger, gamepad, 6D mouse, phone. */
import { type Change, moved, type Quaternion, type Rigid } from "../motion/rigid.ts";

/** Lengths along x, y, z (m), then a turn as axis times angle (rad). The tool turns about its own point. */
export type Move = readonly [number, number, number, number, number, number];
/** What the gripper shall do; empty for nothing. */
export type Grip = "close" | "open" | "";

/** What a hand has done since the reading before, along and about the axes of the arm's base, at the scale 1:1. */
export interface Reading {
  by: Move;
  /** Whether the control is held that has to be held while the arm follows (a dead-man's control). */
  clutch: boolean;
  grip: Grip;
}

export interface Source {
  /** Its name in a sentence. */
  readonly name: string;
  /** Whether it tells a speed, as a stick does; else it tells where the hand is, and a hand comes back the way it went. */
  readonly isRate: boolean;
  /** Return what was done in the `elapsed_s` since the last call; null while nobody uses it, or it is gone. */
  read(elapsed_s: number): Reading | null;
  /** Let go: what is held now counts again only after it was released. */
  forget(): void;
}

export const STILL: Move = [0, 0, 0, 0, 0, 0];
export const HOME: Rigid = { at: [0, 0, 0], turn: [0, 0, 0, 1] satisfies Quaternion };

export function isStill(by: Move): boolean {
  return by.every((v) => v === 0);
}

export function changeOf([x, y, z, ...turn]: Move): Change {
  return { way: [x, y, z], turn };
}

export function moveOf({ way, turn }: Change): Move {
  return [...way, ...turn];
}

/** Return where a hand is that went so far from `HOME`. */
export function placeOf(by: Move): Rigid {
  return moved(HOME, changeOf(by));
}
