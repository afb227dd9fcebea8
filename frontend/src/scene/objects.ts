/** The objects around an arm, from the robot's streams, and where the ghost would be to grasp one or to put it down. */
import type { Pose } from "../motion/chain.ts";
import { type Box, objectsAfter, type Placed } from "../socket/objects.ts";
import type { StreamPacket } from "../socket/packets.ts";
import { distance, wayInWords } from "./moves.ts";
import { inverse, poseAt, product, uprightAt } from "./poses.ts";

export const SNAP_M = 0.002; // so near its goal the ghost is put there
const SNAP_RAD = (2 * Math.PI) / 180;

/** An object as `object_facts` of robots/kit/arms/objects.py tells it: its size in m, colour from 0 to 1, poses 4 x 4. */
export interface ObjectFacts {
  name: string;
  number: number;
  shape: "box" | "cylinder";
  size: [number, number, number];
  colour: [number, number, number];
  turns: number; // by so many equal turns about its z it looks the same
  carries?: string[]; // what may be put on it; "*": everything
  first?: number[]; // its pose in the beginning
  grasps?: number[][]; // poses of the tool in its frame
}
/** A plate with studs: the middle of its underside (m), columns along x and rows along y. */
export interface PlateFacts {
  place: [number, number, number];
  studs: [number, number];
  pitch: number; // m between two studs
  thick: number;
}
/** What is known of an object. `pose` is in the frame of the base, or of the tool that holds it. */
export interface KnownObject {
  facts: ObjectFacts;
  pose: Float64Array;
  held: boolean;
  how: string; // how its place was last known,
  atMs: number; // and when (ms since 1970); NaN where that is not told
}
/** A pose of the tool that is worth a snap, and what it is in words. */
export interface Goal {
  pose: Float64Array;
  what: string;
}

const RAD_AS_M = 0.1; // a turn of 1 rad counts as much as so much length
const ALONE_M = 0.005; // an object stands on another one if no more than this is between them
const UPRIGHT = 0.999; // the cosine of how far an object that carries others may lean
const MOST = 100_000; // bytes of a packet of beliefs

export class SceneObjects {
  private places: ReadonlyMap<number, Placed> = new Map();
  private beliefs: Record<string, { how?: unknown; at_ms?: unknown }> = {};

  private readonly facts: readonly ObjectFacts[];
  private readonly box: Box;
  private readonly release: number;

  /** `release` (m): so far above a surface an object is let go. */
  constructor(facts: readonly ObjectFacts[], box: Box, release: number) {
    [this.facts, this.box, this.release] = [facts, box, release];
  }

  /** Take over a packet of the streams `objects` and `beliefs`. Returns whether it was one that could be read. */
  take(name: string, { key, data }: Pick<StreamPacket, "key" | "data">): boolean {
    if (name === "objects") {
      const after = objectsAfter(this.places, data, key, this.box);
      if (after) this.places = after;
      return after !== null;
    }
    const read = name === "beliefs" && data.length <= MOST ? beliefsIn(data) : null;
    if (read) this.beliefs = read;
    return read !== null;
  }

  /** The objects whose places are known. */
  get all(): KnownObject[] {
    return this.facts.flatMap((facts) => {
      const placed = this.places.get(facts.number),
        belief = this.beliefs[facts.name];
      if (!placed) return [];
      const how = typeof belief?.how === "string" ? belief.how : "",
        atMs = typeof belief?.at_ms === "number" ? belief.at_ms : NaN;
      return [{ facts, pose: poseAt(placed.place, placed.rotation), held: placed.held === true, how, atMs }];
    });
  }

  /** The objects whose places nobody knows: their names, and why. */
  get lost(): { name: string; how: string }[] {
    return this.facts
      .filter(({ number }) => !this.places.has(number))
      .map(({ name }) => ({ name, how: this.beliefs[name]?.how }))
      .flatMap(({ name, how }) => (typeof how === "string" ? [{ name, how }] : []));
  }

  /** The object in the gripper, if there is one. */
  get held(): KnownObject | null {
    return this.all.find(({ held }) => held) ?? null;
  }

  /** Return where the tool would be to grasp an object, or to put down the one that it holds: the nearest goal. */
  goal(tool: Pose): Goal | null {
    const { held } = this,
      goals = held ? this.placesFor(held) : this.grasps();
    return goals.reduce<Goal | null>((best, one) => (!best || costOf(tool, one) < costOf(tool, best) ? one : best), null);
  }

  private grasps(): Goal[] {
    return this.all.flatMap(({ facts, pose }) =>
      (facts.grasps ?? []).flatMap((grasp) =>
        turnsOf(facts).map((angle) => ({
          pose: product(product(pose, uprightAt([0, 0, 0], angle)), grasp),
          what: `the grasp of ${facts.name}`,
        })),
      ),
    );
  }

  private placesFor(held: KnownObject): Goal[] {
    const inHand = inverse(held.pose),
      { facts } = held,
      first = facts.first && [{ at: Float64Array.from(facts.first), what: `where ${facts.name} was first` }];
    return [...this.tops(held), ...(first ?? [])].flatMap(({ at, what }) =>
      turnsOf(facts).map((angle) => ({ pose: product(product(at, uprightAt([0, 0, 0], angle)), inHand), what })),
    );
  }

  /** Return the free tops of objects that may carry the one that is held. */
  private tops({ facts }: KnownObject): { at: Float64Array; what: string }[] {
    const lying = this.all.filter(({ held }) => !held);
    return lying
      .filter((one) => one.pose[10]! > UPRIGHT)
      .filter((one) => (one.facts.carries ?? []).some((name) => name === "*" || name === facts.name))
      .filter((one) => !lying.some((other) => other !== one && standsOn(other, one)))
      .map(({ facts: below, pose }) => {
        const height = pose[11]! + (below.size[2] + facts.size[2]) / 2 + this.release;
        return { at: uprightAt([pose[3]!, pose[7]!, height], Math.atan2(pose[4]!, pose[0]!)), what: `on ${below.name}` };
      });
  }
}

function costOf(tool: Pose, goal: Goal): number {
  const { m, rad } = distance(tool, goal.pose);
  return m + RAD_AS_M * rad;
}

/** Return the goal's pose if the tool is near it, else the pose itself. */
export function snapped(pose: Float64Array, goal: Goal | null): Float64Array {
  const far = goal && distance(pose, goal.pose);
  return goal && far!.m <= SNAP_M && far!.rad <= SNAP_RAD ? goal.pose : pose;
}

/** As `snapped`, but a step that leaves a goal does not snap back to it. */
export function snappedStep(pose: Float64Array, goal: Goal | null, from: Pose | null): Float64Array {
  if (goal && from && costOf(from, goal) <= costOf(pose, goal)) return pose;
  return snapped(pose, goal);
}

/** Return what is missing to a goal, in words. */
export function missingInWords(pose: Pose, { pose: at, what }: Goal): string {
  const way = wayInWords(pose, at);
  return way ? `To ${what}: ${way}.` : `The ghost is at ${what}.`;
}

function standsOn(upper: KnownObject, lower: KnownObject): boolean {
  const gap = upper.pose[11]! - upper.facts.size[2] / 2 - (lower.pose[11]! + lower.facts.size[2] / 2),
    aside = Math.hypot(upper.pose[3]! - lower.pose[3]!, upper.pose[7]! - lower.pose[7]!);
  return Math.abs(gap) < ALONE_M && aside < (Math.max(...upper.facts.size) + Math.max(...lower.facts.size)) / 2;
}

function turnsOf({ turns }: ObjectFacts): number[] {
  return Array.from({ length: turns }, (_, n) => (2 * Math.PI * n) / turns);
}

function beliefsIn(data: Uint8Array): Record<string, { how?: unknown; at_ms?: unknown }> | null {
  try {
    const read: unknown = JSON.parse(new TextDecoder().decode(data));
    const objects = (read as { objects?: unknown } | null)?.objects;
    return typeof objects === "object" && objects !== null ? (objects as Record<string, { how?: unknown }>) : null;
  } catch {
    return null;
  }
}
