/** The ghost of a tool: where the person wants it, where it may be, and how much is missing to its goal. Pure state. */
import type { Joints } from "./chain.ts";
import { Clutch } from "./clutch.ts";
import { Refused } from "./budget.ts";
import type { Planner } from "./planner.ts";
import { between, moved, poseOf, type Rigid, rigidOf } from "./rigid.ts";
import { type Allowed, slide } from "./slide.ts";
import { norm, type Vec3 } from "./vectors.ts";
import { degrees } from "./words.ts";

export const SNAP_M = 0.002;
export const SNAP_RAD = (2 * Math.PI) / 180;
const TETHER_M = 0.02; // so far the hand's wish may be ahead of a ghost that is stopped, or the way back would be long
const TETHER_RAD = 0.2;

/** What is missing to a goal (m, rad), and whether that is so little that the ghost is put there. */
export interface Missing {
  m: number;
  rad: number;
  snaps: boolean;
  words: string; // "12 mm left, 3 degrees"
}

export function missingTo(goal: Rigid, pose: Rigid): Missing {
  const { way, turn } = between(pose, goal),
    m = norm(way),
    rad = norm(turn),
    angle = Math.round(degrees(rad));
  const words = `${Math.round(1000 * m)} mm left, ${angle} degree${angle === 1 ? "" : "s"}`;
  return { m, rad, snaps: m <= SNAP_M && rad <= SNAP_RAD, words };
}

export class Ghost {
  readonly clutch = new Clutch();
  private free: Rigid; // where it is without snapping
  private wanted: Rigid; // where the hand has led it, a little inside of what stopped it
  private goal: Rigid | null = null;
  private readonly allowed: Allowed;
  private readonly centre: Vec3;
  stopped = false; // by a box, a limit or the arm's reach, at the last move

  /** `centre` (m): of the arm's reach, the shoulder. */
  constructor(pose: Rigid, allowed: Allowed, centre: Vec3) {
    this.free = this.wanted = pose;
    this.allowed = allowed;
    this.centre = centre;
  }

  /** Put it somewhere else, as the arm's own tool, when no hand has it. */
  put(pose: Rigid): void {
    if (!this.clutch.engaged) this.free = this.wanted = pose;
  }

  aim(goal: Rigid | null): void {
    this.goal = goal;
  }

  engage(hand: Rigid, now_s: number, scale = 1): boolean {
    this.free = this.wanted = this.pose; // a ghost that snapped begins there
    return this.clutch.engage(hand, now_s, scale);
  }

  release(): void {
    this.clutch.release();
    this.free = this.wanted = this.pose;
  }

  /** Move with the hand. Return whether the hand still has it. */
  move(hand: Rigid, now_s: number): boolean {
    const change = this.clutch.move(hand, now_s);
    if (!change) return false;
    this.wanted = moved(this.wanted, change);
    const { pose, stopped } = slide(this.free, this.wanted, this.allowed, this.centre);
    this.free = pose;
    this.stopped = stopped;
    this.wanted = stopped ? tethered(pose, this.wanted) : pose;
    return true;
  }

  /** Where it is shown: at its goal if almost nothing is missing and the tool may be there. */
  get pose(): Rigid {
    const { goal, free } = this;
    return goal && missingTo(goal, free).snaps && this.allowed(goal) ? goal : free;
  }

  get missing(): Missing | null {
    return this.goal && missingTo(this.goal, this.pose);
  }
}

/** Return the wish, no farther from the ghost than the tether. */
function tethered(pose: Rigid, wanted: Rigid): Rigid {
  const { way, turn } = between(pose, wanted),
    share = Math.min(1, TETHER_M / Math.max(norm(way), 1e-12), TETHER_RAD / Math.max(norm(turn), 1e-12));
  return moved(pose, { way, turn }, share);
}

/** Return whether the arm may stand at a pose of its tool, with joints that begin at these and follow the ghost. */
export function allowedBy(planner: Planner, start: Joints): Allowed {
  let near = Array.from(start);
  return (pose) => {
    try {
      const joints = planner.reach(poseOf(pose), near);
      planner.stand(joints, start); // not from `near`, or each step could be a little deeper inside
      near = joints;
      return true;
    } catch (error) {
      if (error instanceof Refused) return false;
      throw error;
    }
  };
}

/** Return a ghost at the tool of an arm with these joints. */
export function ghostOf(planner: Planner, joints: Joints): Ghost {
  const shoulder = planner.chain.frames(joints).subarray(12, 24);
  return new Ghost(rigidOf(planner.chain.forward(joints)), allowedBy(planner, joints), [shoulder[3]!, shoulder[7]!, shoulder[11]!]);
}
