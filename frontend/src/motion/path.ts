/** Joint motions: third-order polynomials to rest at the target (robots/kit/arms/path.py, with its sources). */
import { Refused } from "./budget.ts";
import type { Chain, Joints } from "./chain.ts";

const SHORTEST_S = 0.05;
const LONGEST_S = 900;
const TRIED = 32; // motion times at once

/** The limits of a path: positions (rad), speeds (rad/s), accelerations (rad/s2). */
export interface Limits {
  low: readonly number[];
  high: readonly number[];
  velocity: readonly number[];
  acceleration: readonly number[];
}

/** Return the arm's limits; each joint may reach its full speed within `acceleration_s`. */
export function limitsOf({ joints }: Chain, acceleration_s: number): Limits {
  const velocity = joints.map((joint) => joint.velocity);
  return {
    low: joints.map(({ low }) => low),
    high: joints.map(({ high }) => high),
    velocity,
    acceleration: velocity.map((v) => v / acceleration_s),
  };
}

/** q(t) = a0 + a1 t + a2 t^2 + a3 t^3 for each joint, at rest at the target after `seconds`. */
export class Cubic {
  readonly seconds: number;
  private readonly a: readonly (readonly [number, number, number, number])[];

  /** From a sampled position and velocity to rest at the target (Craig 1986, 7.11). */
  constructor(start: Joints, velocity: Joints, target: Joints, seconds: number) {
    this.seconds = seconds;
    this.a = Array.from(start, (from, n) => {
      const way = target[n]! - from,
        v = velocity[n]!;
      return [from, v, (3 * way) / seconds ** 2 - (2 * v) / seconds, (-2 * way) / seconds ** 3 + v / seconds ** 2];
    });
  }

  /** Return the positions after `t` seconds; before the start and after the end the arm rests there. */
  sample(t: number, out: Float64Array = new Float64Array(this.a.length)): Float64Array {
    const at = Math.min(Math.max(t, 0), this.seconds);
    for (const [n, [a0, a1, a2, a3]] of this.a.entries()) out[n] = a0 + at * (a1 + at * (a2 + at * a3));
    return out;
  }

  /** Return each joint's greatest speed (rad/s) on the way. */
  fastest(): number[] {
    return this.a.map(([, a1, a2, a3]) => peak(a1, a2, a3, this.seconds));
  }

  /** Return the least and the greatest position (rad) of each joint on the way. */
  span(): [number, number][] {
    return this.a.map(([a0, a1, a2, a3]) => {
      const half = -(a2 + Math.sign(a2 || 1) * Math.sqrt(a2 * a2 - 3 * a3 * a1)); // if the speed has no root, or one
      const times = [half / (3 * a3), a1 / half].map((t) => (Number.isFinite(t) ? Math.min(Math.max(t, 0), this.seconds) : 0));
      const q = [...times, 0, this.seconds].map((t) => a0 + t * (a1 + t * (a2 + t * a3)));
      return [Math.min(...q), Math.max(...q)];
    });
  }
}

function peak(a1: number, a2: number, a3: number, seconds: number): number {
  const turn = Math.abs(a3) > 1e-12 ? Math.min(Math.max(-a2 / (3 * a3), 0), seconds) : 0;
  return Math.max(Math.abs(a1), Math.abs(a1 + turn * (2 * a2 + 3 * a3 * turn)));
}

/**
 * Return the shortest polynomial to `target` that keeps the limits, speeds scaled by `scale` (0 to 1]. Throws Refused:
 * the present velocity carries a joint past its limit whatever the time.
 */
export function jointPath(start: Joints, velocity: Joints, target: Joints, limits: Limits, scale: number): Cubic {
  const resting = Array.from(velocity).every((v) => v === 0),
    path = new Cubic(start, velocity, target, shortest(start, velocity, target, limits, scale, resting));
  if (resting) return path; // from rest to rest no joint leaves the range between start and target
  for (const [n, [low, high]] of path.span().entries())
    if (low < Math.min(limits.low[n]!, start[n]!) - 1e-9 || high > Math.max(limits.high[n]!, start[n]!) + 1e-9)
      throw new Refused("busy", "the arm moves too fast towards a limit to turn round; it brakes first");
  return path;
}

function shortest(start: Joints, velocity: Joints, target: Joints, limits: Limits, scale: number, resting: boolean): number {
  const ways = Array.from(target, (value, n) => value - start[n]!),
    speeds = limits.velocity.map((full, n) => Math.max(full * scale, Math.abs(velocity[n]!)));
  const seconds = resting
    ? Math.max(
        ...ways.map((way, n) => Math.max((1.5 * Math.abs(way)) / speeds[n]!, Math.sqrt((6 * Math.abs(way)) / limits.acceleration[n]!))),
      )
    : firstThatKeeps(ways, velocity, speeds, limits.acceleration);
  if (seconds > LONGEST_S) throw new Refused("busy", "no motion time keeps the limits");
  return Math.max(SHORTEST_S, seconds);
}

/** Return the shortest time (s) found by trying a coarse grid, then two finer ones; infinite if there is none. */
function firstThatKeeps(ways: number[], velocity: Joints, speeds: number[], hard: readonly number[]): number {
  const low = Math.log10(SHORTEST_S),
    step = (Math.log10(LONGEST_S) - low) / (TRIED - 1);
  let times = Array.from({ length: TRIED }, (_, k) => (k === 0 ? SHORTEST_S : k === TRIED - 1 ? LONGEST_S : 10 ** (low + k * step)));
  for (let round = 0; round < 3; round++) {
    const first = times.findIndex((t) => keeps(t, ways, velocity, speeds, hard));
    if (first < 0) return Infinity;
    if (first === 0) return times[0]!;
    const from = times[first - 1]!,
      to = times[first]!;
    times = times.map((_, k) => (k === TRIED - 1 ? to : from + (k * (to - from)) / (TRIED - 1)));
  }
  return times.at(-1)!;
}

/** Return whether the polynomial of this motion time keeps speeds and accelerations. */
function keeps(t: number, ways: number[], velocity: Joints, speeds: number[], hard: readonly number[]): boolean {
  return ways.every((way, n) => {
    const v = velocity[n]!,
      a2 = (3 * way) / t ** 2 - (2 * v) / t,
      a3 = (-2 * way) / t ** 3 + v / t ** 2;
    const hardest = Math.max(Math.abs(2 * a2), Math.abs(2 * a2 + 6 * a3 * t));
    return peak(v, a2, a3, t) <= speeds[n]! * (1 + 1e-9) && hardest <= hard[n]! * (1 + 1e-9);
  });
}
