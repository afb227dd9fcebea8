/** Moves of the ghost: lengths along, and turns about, the axes of the arm's base; and the same in words. */
import type { Move } from "../input/source.ts";
import type { Pose } from "../motion/chain.ts";
import { missing } from "../motion/linear.ts";
import { moved as movedRigid, poseOf, rigidOf } from "../motion/rigid.ts";
import { gettext, translate } from "../kit/text.ts";

/** How far a key or a button moves (mm) and turns (degrees) the ghost. */
export interface Step {
  mm: number;
  degrees: number;
}

export const STEPS: readonly Step[] = [
  { mm: 1, degrees: 1 },
  { mm: 5, degrees: 5 },
  { mm: 20, degrees: 15 },
  { mm: 100, degrees: 45 },
];
export const USUAL = 1; // the index of the step with which a turn begins
type Said = (value: string) => string;
const LENGTHS: readonly (readonly [Said, Said])[] = [
  [(mm) => gettext("{mm} mm forward", { mm }), (mm) => gettext("{mm} mm back", { mm })],
  [(mm) => gettext("{mm} mm left", { mm }), (mm) => gettext("{mm} mm right", { mm })],
  [(mm) => gettext("{mm} mm up", { mm }), (mm) => gettext("{mm} mm down", { mm })],
];
const AXES = ["x", "y", "z"] as const;
const RAD_AS_M = 0.1; // a turn of 1 rad counts as much as so much length
const LEAST_MM = 0.5,
  LEAST_DEG = 0.5; // smaller ones are none, in words

/** Return `pose` (4 x 4, row by row) moved. */
export function moved(pose: Pose, [x, y, z, ...turn]: Move): Float64Array {
  return poseOf(movedRigid(rigidOf(pose), { way: [x, y, z], turn }));
}

/** Return x, y, z (m) and roll, pitch, yaw (rad) of a pose, as commands have them (robots/kit/arms/pose.py). */
export function numbersOfPose(pose: Pose): number[] {
  const r = (row: number, column: number): number => pose[4 * row + column]!,
    flat = Math.hypot(r(0, 0), r(1, 0)),
    pitch = Math.atan2(-r(2, 0), flat);
  const turns =
    flat > 1e-9 ? [Math.atan2(r(2, 1), r(2, 2)), pitch, Math.atan2(r(1, 0), r(0, 0))] : [0, pitch, Math.atan2(-r(0, 1), r(1, 1))];
  return [r(0, 3), r(1, 3), r(2, 3), ...turns];
}

/** Return the pose at the same place with the tool pointing straight down, turned as in position mode. */
export function pointingDown(pose: Pose): Float64Array {
  return Float64Array.of(-1, 0, 0, pose[3]!, 0, 1, 0, pose[7]!, 0, 0, -1, pose[11]!, 0, 0, 0, 1);
}

/** How far it is from one pose to another: length (m) and angle (rad). */
export function distance(from: Pose, to: Pose): { m: number; rad: number } {
  const way = missing(from, to);
  return { m: Math.hypot(...way.slice(0, 3)), rad: Math.hypot(...way.slice(3)) };
}

/** Return how far it is from one pose to another as one number (m). */
export function cost(from: Pose, to: Pose): number {
  const { m, rad } = distance(from, to);
  return m + RAD_AS_M * rad;
}

/** Return the way from one pose to another in words, as "12 mm left, 3 mm up, 3° about z"; empty if there is none. */
export function wayInWords(from: Pose, to: Pose): string {
  const way = missing(from, to);
  const lengths = LENGTHS.map(([plus, minus], i) => {
    const mm = Math.abs(way[i]! * 1000);
    return mm < LEAST_MM ? "" : (way[i]! > 0 ? plus : minus)(mm.toFixed(0));
  });
  const turns = AXES.map((axis, i) => {
    const degrees = (way[i + 3]! * 180) / Math.PI;
    return Math.abs(degrees) < LEAST_DEG ? "" : gettext("{degrees}° about {axis}", { degrees: degrees.toFixed(0), axis });
  });
  return [...lengths, ...turns].filter(Boolean).join(", ");
}

/** Return where a pose is, as "x, y, z 663, 0, 456 mm; roll, pitch, yaw 180, 0, 180°". */
export function placeInWords(pose: Pose): string {
  const numbers = numbersOfPose(pose),
    at = numbers.slice(0, 3).map((v) => whole(v * 1000)),
    turn = numbers.slice(3).map((v) => whole((v * 180) / Math.PI, true));
  return gettext("x, y, z {place} mm; roll, pitch, yaw {turn}°", { place: at.join(", "), turn: turn.join(", ") });
}

/** Return why the arm cannot go somewhere as a sentence. */
export function refusalInWords(why: string): string {
  return gettext("The arm cannot go there: {why}.", { why: translate(why) });
}

/** Return a number without decimals; no zero with a sign, and half a turn as 180. */
function whole(value: number, isAngle = false): string {
  const rounded = Math.round(value) || 0;
  return String(isAngle && rounded === -180 ? 180 : rounded);
}

export type { Move };
type Way = readonly [number, number, number];
const KEYS: Record<string, { move: Way; turn: Way }> = {
  ArrowUp: { move: [1, 0, 0], turn: [0, 1, 0] },
  ArrowDown: { move: [-1, 0, 0], turn: [0, -1, 0] },
  ArrowLeft: { move: [0, 1, 0], turn: [0, 0, 1] },
  ArrowRight: { move: [0, -1, 0], turn: [0, 0, -1] },
  PageUp: { move: [0, 0, 1], turn: [1, 0, 0] },
  PageDown: { move: [0, 0, -1], turn: [-1, 0, 0] },
};

/** Return the move of a step along a direction, or about it; the six numbers say how many steps. */
export function stepMove([x, y, z, ...turn]: Move, { mm, degrees }: Step): Move {
  const m = mm / 1000,
    rad = (degrees * Math.PI) / 180;
  return [x * m, y * m, z * m, turn[0] * rad, turn[1] * rad, turn[2] * rad];
}

/** Return where a key moves the ghost, in steps; null if it is none of its keys. With `turns` (Shift) it turns it. */
export function keyMove(key: string, turns: boolean): Move | null {
  if (!Object.hasOwn(KEYS, key)) return null;
  const { move, turn } = KEYS[key]!;
  return turns ? [0, 0, 0, ...turn] : [...move, 0, 0, 0];
}

/** Return a part of a move, as the scale 1:n makes it of the hand's. */
export function shareOf(move: Move, share: number): Move {
  return move.map((v) => v * share) as unknown as Move;
}
