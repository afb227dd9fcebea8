/** What the arm is told while it follows: how far the ghost has gone since it was taken, approached at a bounded speed. */
import { between, moved, type Rigid } from "../motion/rigid.ts";
import { norm, times, type Vec3 } from "../motion/vectors.ts";
import { turnOf } from "../motion/linear.ts";
import { changeOf, HOME, type Move, placeOf } from "./source.ts";
import { isJump } from "./clutch.ts";

/** The arguments of `follow`, in the order of a move (robots/kit/arms/follow.py). */
const NAMES = ["dx", "dy", "dz", "rx", "ry", "rz"] as const;
const M_PER_S = 0.3,
  RAD_PER_S = 2; // no arm follows as fast; with keep-alives that are lost for 0.25 s it is no jump for the server
const LONGEST_S = 0.1; // of one step
const FARTHEST_M = 1; // of the argument

/** Return whether a hand that has moved so since its reading before is lost. */
export function isLost(by: Move): boolean {
  return isJump(changeOf(by));
}

export class Steering {
  private at: Rigid = HOME;

  /** Return the arguments of the next keep-alive, on the way to `wanted`, which is how far the ghost is from its start. */
  next(wanted: Move, elapsed_s: number): Record<string, number> {
    const seconds = Math.max(0, Math.min(LONGEST_S, elapsed_s)),
      { way, turn } = between(this.at, placeOf(wanted));
    this.at = moved(this.at, { way: limited(way, M_PER_S * seconds), turn: limited(turn, RAD_PER_S * seconds) });
    const far = norm(this.at.at);
    if (far > FARTHEST_M) this.at = { ...this.at, at: times(this.at.at, FARTHEST_M / far) };
    return argumentsOf([...this.at.at, ...(turnOf(this.at.turn) as unknown as Vec3)]);
  }
}

/** Return a place of the hand as the arguments of the command. */
export function argumentsOf(move: Move): Record<string, number> {
  return Object.fromEntries(NAMES.map((name, i) => [name, Math.round(move[i]! * 1e5) / 1e5 || 0]));
}

function limited(v: Vec3, most: number): Vec3 {
  const length = norm(v);
  return length > most ? times(v, most / length) : v;
}
