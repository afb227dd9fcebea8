/** Judges where the ghost is, in the page: where the arm could rest, and by which way it would come there. */
import { Budget, Refused } from "../motion/budget.ts";
import { FRAME, type Joints, type Pose } from "../motion/chain.ts";
import type { ArmFacts, BoxFacts } from "../motion/facts.ts";
import { Planner } from "../motion/planner.ts";
import { between, poseOf, type Rigid, rigidOf } from "../motion/rigid.ts";
import { slide } from "../motion/slide.ts";
import { norm } from "../motion/vectors.ts";
import { gettext, translate } from "../kit/text.ts";

/**
 * What would happen at a pose. `free`: the arm comes there; `way`: it could rest there, but a box is in the way;
 * `refused`: it cannot be there. `text`: why not, in the server's words, without a full stop.
 */
export interface Judgement {
  verdict: "free" | "way" | "refused";
  text: string;
  joints: readonly number[] | null; // rad
  path: readonly (readonly number[])[]; // places of the tool on the way (m)
  seconds: number; // NaN where only the server can say
}
export interface Wish {
  pose: Pose;
  straight: boolean;
  share: number; // of full speed
}

const POINTS = 24; // of a path that is drawn
const PLAY_S = 0.1;
const ROUNDS = 3, // of sliding: one goes no farther than a few hundred millimetres
  LEAST_M = 0.001;

export class PoseJudge {
  readonly planner: Planner;

  /** `added`: boxes of staff. Throws an Error if no closed form is known for the arm. */
  constructor(facts: ArmFacts, added: readonly BoxFacts[]) {
    this.planner = new Planner(facts, added);
  }

  /** Return the pose of the tool at these joints (rad). */
  tool(joints: Joints): Float64Array {
    return this.planner.chain.forward(joints);
  }

  /** Return how far the tool comes on its way to a pose at which it cannot be: to a surface, and along it. */
  along(from: Pose, to: Pose, present: Joints): Float64Array {
    const { chain } = this.planner,
      shoulder = chain.frames(present).subarray(FRAME, 2 * FRAME),
      centre = [shoulder[3]!, shoulder[7]!, shoulder[11]!] as const,
      wanted = rigidOf(to);
    const allowed = (pose: Rigid): boolean => typeof this.rest(poseOf(pose), present) !== "string";
    let here = rigidOf(from);
    for (let round = 0; round < ROUNDS; round++) {
      const { pose } = slide(here, wanted, allowed, centre),
        gone = norm(between(here, pose).way);
      here = pose;
      if (gone < LEAST_M) break;
    }
    return poseOf(here);
  }

  /** Return what would happen at that pose, from these joints at rest. A straight way is judged by the server alone. */
  judge({ pose, straight, share }: Wish, present: Joints): Judgement {
    const there = this.rest(pose, present);
    if (typeof there === "string") return { verdict: "refused", text: there, joints: null, path: [], seconds: NaN };
    if (straight) return { verdict: "free", text: "", joints: there, path: [placeOf(this.tool(present)), placeOf(pose)], seconds: NaN };
    const outcome = this.planner.plan({ joints: there }, { joints: present }, share);
    if (!outcome.ok) return { verdict: "way", text: outcome.text, joints: there, path: [], seconds: NaN };
    const { path, seconds } = outcome,
      places = Array.from({ length: POINTS }, (_, n) => placeOf(this.tool(path.sample((seconds * n) / (POINTS - 1)))));
    return { verdict: "free", text: "", joints: there, path: places, seconds };
  }

  /** Return the way through poses of the tool, a posture each tenth of a second; or why there is none, as a sentence. */
  through(poses: readonly Pose[], present: Joints, share: number): { joints: number[][]; tool: number[][] } | string {
    const joints: number[][] = [];
    let here: Joints = present;
    for (const [n, pose] of poses.entries()) {
      const there = this.rest(pose, here);
      if (typeof there === "string")
        return gettext("The arm cannot be at place {number}: {why}.", { number: n + 1, why: translate(there) });
      const outcome = this.planner.plan({ joints: there }, { joints: here }, share);
      if (!outcome.ok)
        return gettext("The arm cannot come to place {number} directly: {why}.", { number: n + 1, why: translate(outcome.text) });
      const { path, seconds } = outcome;
      for (let t = 0; t < seconds; t += PLAY_S) joints.push([...path.sample(t)]);
      joints.push([...there]);
      here = there;
    }
    return { joints, tool: joints.map((q) => placeOf(this.tool(q))) };
  }

  /** Return joints at which the arm rests there, or why it cannot. */
  private rest(pose: Pose, present: Joints): number[] | string {
    try {
      const joints = this.planner.reach(pose, present, new Budget());
      this.planner.stand(joints, present);
      return joints;
    } catch (error) {
      if (error instanceof Refused) return error.message;
      throw error;
    }
  }
}

function placeOf(pose: Pose): number[] {
  return [pose[3]!, pose[7]!, pose[11]!];
}
