/**
 * The nearest inverse solution of an arm (robots/kit/arms/inverse.py): over all branches, all whole turns inside the
 * limits and, at a singular pose, all shares of the joints that turn against each other.
 *
 * Both sides choose the same, but for singular poses: there an answer within 0.05 s is taken as it is found, so joints that
 * turn against each other may share a turn otherwise; and where the wrist stands above the first axis, the answers are a
 * curve, of which each side finds a near one.
 */
import { Branches } from "./branches.ts";
import { type Budget, Refused, SHARED } from "./budget.ts";
import type { Chain, Joints, Pose } from "./chain.ts";
import { cost, nearestOf } from "./nearest.ts";
import { aboutSingular, nearestShare, polished } from "./singular.ts";
import { fixed, general } from "./words.ts";

const EXACT = 1e-9; // an answer counts if no number of its pose differs by more (m, or of a rotation)
const SAME_POSE = 2e-6; // m, or of a rotation: the tool is there already, as a pose is told with five decimals of a degree
// An answer no farther than this (s at full speed) is the nearest. Python has less: a ghost that is dragged by less than
// `SAME_POSE` at a time must move, too, and not enter a box by so much.
const AT_ONCE_S = 1e-4;
const NEAR_S = 0.05; // up to this it is as good as the nearest
const SLACK_RAD = 1e-9;
const CLOSE_M = 1e-3; // a larger error is not just lost precision at a singular pose
const BESIDE = 0.01; // see `polished`
const ALIKE_RAD = 1e-6; // angles that differ by less are the same in a refusal
const TURN = 2 * Math.PI;

export class Inverse {
  private readonly chain: Chain;
  private readonly branches: Branches;
  private readonly longest: number; // m

  /** Throws an Error if no closed form is known for the arm. */
  constructor(chain: Chain) {
    this.chain = chain;
    this.branches = new Branches(chain);
    this.longest = [...chain.joints.map((joint) => joint.origin), chain.tool].reduce((sum, pose) => sum + far(pose), 0);
  }

  /**
   * Return the answer whose slowest joint has the shortest way from `near`; `near` itself if the tool is there already.
   * Throws Refused: the pose cannot be reached, or needs more work than the budget allows.
   */
  nearest(pose: Pose, near: Joints, budget: Budget): number[] {
    const { chain } = this;
    this.bounded(pose);
    const branches = this.branches.of(pose),
      best = nearestOf(chain, this.inTurns(branches, near), near);
    const exact = best !== null && this.exact(best, pose),
      { slowest } = best ? cost(chain, best, near) : { slowest: Infinity };
    if (exact && slowest <= AT_ONCE_S) return best;
    if (this.exact(near, pose, SAME_POSE) && !chain.brokenLimit(near)) return Array.from(near);
    if (exact && slowest <= NEAR_S) return best;
    const regular = exact ? [best] : this.inTurns(branches, near).filter((q) => this.exact(q, pose));
    const found = nearestOf(chain, [...regular, ...this.shared(branches, pose, near, budget)], near);
    if (!found) throw this.refusal(branches, pose);
    return found;
  }

  /** Throw Refused for a pose far from the arm, or none. */
  private bounded(pose: Pose): void {
    const distance = far(pose);
    let sum = 0;
    for (let i = 0; i < 12; i++) sum += pose[i] ?? NaN;
    if (distance <= 2 * this.longest && Number.isFinite(sum)) return;
    const where = Number.isFinite(distance) ? `${general(distance, 3)} m from the base` : "not a position";
    throw new Refused("range", `that is ${where}: the arm reaches ${fixed(this.longest, 2)} m at most`);
  }

  /** Return the branches that are inside the limits, each in the turns nearest to `near`. */
  private inTurns(branches: number[][], near: Joints): number[][] {
    return branches.map((q) => this.turned(q, near)).filter((q) => q !== null);
  }

  private turned(branch: number[], near: Joints): number[] | null {
    const q: number[] = [];
    for (const [n, { low, high }] of this.chain.joints.entries()) {
      const here = near[n]!;
      let value = here + remainder(branch[n]! - here);
      if (value < low - SLACK_RAD) value += TURN * Math.ceil((low - SLACK_RAD - value) / TURN);
      else if (value > high + SLACK_RAD) value -= TURN * Math.ceil((value - high - SLACK_RAD) / TURN);
      if (!(low - SLACK_RAD <= value && value <= high + SLACK_RAD)) return null;
      q.push(value);
    }
    return q;
  }

  private exact(q: Joints, pose: Pose, within = EXACT): boolean {
    const there = this.chain.forward(q);
    for (let i = 0; i < 12; i++) if (!(Math.abs(there[i]! - pose[i]!) < within)) return false;
    return true;
  }

  /** Return answers at a singular pose, where a branch is only one of many. Throws Refused. */
  private shared(branches: number[][], pose: Pose, near: Joints, budget: Budget): number[][] {
    const { chain } = this,
      found: number[][] = [];
    const about = branches.filter((q) => this.close(q, pose) && aboutSingular(chain, q));
    for (const q of about) {
      budget.spend(SHARED);
      const share = nearestShare(chain, this.into(q), pose, near);
      if (share) found.push(share);
    }
    const beside = about.length ? polished(chain, near, pose, BESIDE) : null;
    if (beside && !chain.brokenLimit(beside)) found.push(beside);
    return found;
  }

  private close(q: Joints, pose: Pose): boolean {
    const there = this.chain.forward(q);
    return [3, 7, 11].every((i) => Math.abs(there[i]! - pose[i]!) < CLOSE_M);
  }

  private refusal(branches: number[][], pose: Pose): Refused {
    const { chain } = this,
      inside = branches.filter((q) => this.exact(q, pose)).map((q) => this.into(q));
    if (!inside.length) {
      const missed = Math.min(...branches.map((q) => offset(chain.forward(q), pose)));
      return new Refused("range", `the tool would remain ${fixed(missed, 3)} m away: the arm is too short, or too long, for that`);
    }
    const outside = inside.map((q) => chain.joints.reduce((sum, { low, high }, n) => sum + Math.max(0, low - q[n]!, q[n]! - high), 0));
    // branches often lie as far outside as their mirror images: then greater angles count
    const least = Math.min(...outside) + ALIKE_RAD,
      alike = inside.filter((_, k) => outside[k]! <= least);
    return new Refused("range", chain.brokenLimit(alike.reduce((a, b) => (greater(b, a) ? b : a))));
  }

  /** Return `q` with each joint turned by a whole turn into its limits if possible. */
  private into(q: readonly number[]): number[] {
    return this.chain.joints.map(({ low, high }, n) => {
      let value = remainder(q[n]!);
      if (value < low && value + TURN <= high + SLACK_RAD) value += TURN;
      if (value > high && value - TURN >= low - SLACK_RAD) value -= TURN;
      return value;
    });
  }
}

/** Return the angle less whole turns, at most half a turn (IEEE remainder). */
function remainder(angle: number): number {
  const rest = angle % TURN;
  return rest > Math.PI ? rest - TURN : rest < -Math.PI ? rest + TURN : rest;
}

function far(pose: Pose): number {
  return Math.hypot(pose[3] ?? NaN, pose[7] ?? NaN, pose[11] ?? NaN);
}

function offset(a: Pose, b: Pose): number {
  return Math.hypot(a[3]! - b[3]!, a[7]! - b[7]!, a[11]! - b[11]!);
}

/** Return whether the first angle that differs is the greater. */
function greater(a: readonly number[], b: readonly number[]): boolean {
  const first = a.findIndex((value, n) => Math.round(value / ALIKE_RAD) !== Math.round(b[n]! / ALIKE_RAD));
  return first >= 0 && a[first]! > b[first]!;
}
