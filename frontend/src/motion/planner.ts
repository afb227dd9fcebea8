/**
 * Plans an arm's motions in the browser: limits, kinematics, path and boxes, with the words of the server
 * (robots/kit/arms/planner.py, motions.py). It only shows what a command would do: server and controller judge again.
 */
import { Budget, MOTION, Refused } from "./budget.ts";
import { Chain, type Joints, type Pose } from "./chain.ts";
import type { ArmFacts, BoxFacts } from "./facts.ts";
import { Inverse } from "./inverse.ts";
import { type Cubic, jointPath, type Limits, limitsOf } from "./path.ts";
import { swept } from "./sweep.ts";
import { fixed, general } from "./words.ts";
import { inWords, Zones } from "./zones.ts";

/** Where to: joints (rad), or a pose of the tool. */
export type Target = { joints: Joints } | { pose: Pose };
/** Where the arm is now (rad), and how fast its joints turn (rad/s); at rest if that is left out. */
export interface Present {
  joints: Joints;
  velocity?: Joints;
}
export type Outcome =
  { ok: true; joints: readonly number[]; path: Cubic; seconds: number } | { ok: false; code: Refused["code"]; text: string };

export class Planner {
  readonly chain: Chain;
  readonly zones: Zones; // as they are;
  private readonly widened: Zones; // planned motions keep away from them, because an arm follows with an error
  private readonly inverse: Inverse;
  private readonly limits: Limits;
  private readonly motion: ArmFacts["motion"];

  /** `added`: boxes that staff have added to the arm's own. Throws an Error if no closed form is known for the arm. */
  constructor(facts: ArmFacts, added: readonly BoxFacts[] = []) {
    const boxes = [...facts.boxes, ...added],
      { limbs, clearance_m, acceleration_s } = facts.motion;
    this.motion = facts.motion;
    this.chain = new Chain(facts);
    this.zones = new Zones(this.chain, limbs, boxes);
    this.widened = new Zones(this.chain, limbs, boxes, clearance_m);
    this.inverse = new Inverse(this.chain);
    this.limits = limitsOf(this.chain, acceleration_s);
  }

  /** Return the motion to a target at a share of full speed, or why there is none. */
  plan(target: Target, present: Present, scale: number = this.motion.scale): Outcome {
    try {
      const { joints, path } = this.motionTo(target, present, scale);
      return { ok: true, joints, path, seconds: path.seconds };
    } catch (error) {
      if (error instanceof Refused) return { ok: false, code: error.code, text: error.message };
      throw error;
    }
  }

  private motionTo(target: Target, { joints: here, velocity }: Present, scale: number): { joints: number[]; path: Cubic } {
    const { count } = this.chain,
      speeds = velocity ?? new Float64Array(count),
      budget = new Budget();
    if (!known(here, count) || !known(speeds, count)) throw new Refused("busy", "the present joints are not known");
    const [low = 0, high = 1] = this.motion.scale_range;
    if (!(low <= scale && scale <= high))
      throw new Refused("range", `the share of full speed must lie between ${general(low)} and ${general(high)}`);
    const joints = "pose" in target ? this.inverse.nearest(target.pose, here, budget) : Array.from(target.joints);
    const path = this.joints(joints, here, speeds, scale, budget),
      longest = this.motion.limit_s;
    if (path.seconds > longest)
      throw new Refused(
        "range",
        `the motion would take ${fixed(path.seconds, 0)} s, longer than the ${general(longest)} s that one may take; ` +
          "ask for more of full speed, or go less far",
      );
    return { joints, path };
  }

  /** Return the joints for a pose, the answer nearest to `near`. Throws Refused. */
  reach(pose: Pose, near: Joints, budget = new Budget()): number[] {
    return this.inverse.nearest(pose, near, budget);
  }

  /** Return the joint motion from the sampled position and velocity. Throws Refused, which names the joint, or limb and box. */
  joints(target: Joints, q: Joints, velocity: Joints, scale: number, budget = new Budget()): Cubic {
    budget.spend(MOTION);
    this.stand(target, q);
    const path = jointPath(q, velocity, target, this.limits, scale),
      found = swept(this.widened, path, budget);
    if (found) throw new Refused("box", `on the way there, after ${fixed(found.seconds, 1)} s, ${inWords(found.touch)}`);
    return path;
  }

  /** Refuse joints at which the arm must not rest; an arm inside a box at `q` may rest less deep inside. Throws Refused. */
  stand(target: Joints, q: Joints): void {
    const broken = this.chain.brokenLimit(target);
    if (broken) throw new Refused("range", broken);
    if (this.widened.clear(target)) return;
    const touch = this.widened.entered(this.widened.distances(target), Zones.floor(this.widened.distances(q)));
    if (touch) throw new Refused("box", `there ${inWords(touch)}`);
  }
}

function known(values: Joints, count: number): boolean {
  return values.length === count && Array.from(values).every(Number.isFinite);
}
