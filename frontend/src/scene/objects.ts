/** The objects around an arm, from the robot's streams, and where the ghost would be to grasp one or to put it down. */
import type { Pose } from "../motion/chain.ts";
import { type Box, objectsAfter, type Placed } from "../socket/objects.ts";
import type { StreamPacket } from "../socket/packets.ts";
import type { TaskStep } from "../widgets/task_text.ts";
import { type GoalFacts, type Reached, reachedIn } from "./goals.ts";
import { cost, distance, wayInWords } from "./moves.ts";
import type { KnownObject, ObjectFacts, PlateFacts } from "./known.ts";
import { type Around, isUpright, nearestStud, stepFor, yawOf } from "./placing.ts";
import { alike, inverse, poseAt, product, uprightAt } from "./poses.ts";
import { gettext, translate } from "../kit/text.ts";

export const SNAP_M = 0.002; // so near its goal the ghost is put there
const SNAP_RAD = (2 * Math.PI) / 180;

/** What there is beside the objects: a plate, goals, how high the table is (m). */
export interface Beside {
  plate?: PlateFacts | undefined;
  goals?: readonly GoalFacts[] | undefined;
  table_m?: number | undefined;
}
/** Where the objects of a task that is recorded are: of a held one in the frame of the tool. */
export type Copies = ReadonlyMap<number, { pose: Float64Array; held: boolean }>;
/** A pose of the tool that is worth a snap, and what it is in words. */
export interface Goal {
  pose: Float64Array;
  what: string;
}

const ALONE_M = 0.005; // an object stands on another one if no more than this is between them
const SAME_M = 0.0007; // between goals that count as one place: so exactly an object is measured
const MOST = 100_000; // bytes of a packet of beliefs

export class SceneObjects {
  private places: ReadonlyMap<number, Placed> = new Map();
  private beliefs: Record<string, { how?: unknown; at_ms?: unknown }> = {};
  private copies: Copies | null = null;
  /** How far the goals are, by name; null before the robot has told it. */
  reached: Record<string, Reached> | null = null;

  private readonly facts: readonly ObjectFacts[];
  private readonly box: Box;
  private readonly letGo: number;
  readonly plate: PlateFacts | null;
  readonly goals: readonly GoalFacts[];
  private readonly table: number;

  /** `release` (m): so far above a surface an object is let go. */
  constructor(facts: readonly ObjectFacts[], box: Box, release: number, { plate, goals = [], table_m = 0 }: Beside = {}) {
    [this.facts, this.box, this.letGo] = [facts, box, release];
    [this.plate, this.goals, this.table] = [plate ?? null, goals, table_m];
  }

  /** Take over a packet of the streams `objects` and `beliefs`. Returns whether it was one that could be read. */
  take(name: string, { key, data }: Pick<StreamPacket, "key" | "data">): boolean {
    if (name === "objects") {
      const after = objectsAfter(this.places, data, key, this.box);
      if (after) this.places = after;
      return after !== null;
    }
    const read = name === "beliefs" && data.length <= MOST ? beliefsIn(data) : null;
    if (read) {
      this.beliefs = read.objects;
      this.reached = reachedIn(read.goals);
    }
    return read !== null;
  }

  /** The objects whose places are known; while a task is recorded, where they would be. */
  get all(): KnownObject[] {
    if (!this.copies) return this.known;
    const { copies } = this;
    return this.known.map((one) => {
      const copy = copies.get(one.facts.number);
      return copy && (copy.held !== one.held || copy.pose.some((v, i) => Math.abs(v - one.pose[i]!) > 1e-6))
        ? { ...one, ...copy, planned: true }
        : one;
    });
  }

  /** The objects as the robot knows them. */
  get known(): KnownObject[] {
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

  get isCopied(): boolean {
    return this.copies !== null;
  }

  /** Return a copy of where the objects are. */
  copy(): Copies {
    return new Map(this.all.map(({ facts, pose, held }) => [facts.number, { pose, held }]));
  }

  /** Show the objects as in a copy; null: as the robot knows them. */
  restore(copies: Copies | null): void {
    this.copies = copies;
  }

  /** In the copy, let the tool hold an object. */
  hold(name: string, tool: Pose): void {
    this.change(name, (one) => ({ pose: product(inverse(tool), one.pose), held: true }));
  }

  /** In the copy, put down what the tool holds. */
  release(tool: Pose): void {
    const { held } = this;
    if (!held) return;
    const isUp = isUpright(product(tool, held.pose));
    this.change(held.facts.name, (one) => {
      const pose = product(tool, one.pose);
      pose[11]! -= isUp ? this.letGo : 0;
      return { pose, held: false };
    });
  }

  private change(name: string, to: (one: KnownObject) => { pose: Float64Array; held: boolean }): void {
    const one = this.all.find(({ facts }) => facts.name === name);
    if (one && this.copies) this.copies = new Map([...this.copies, [one.facts.number, to(one)]]);
  }

  /** Return the nearest grasp of an object, and whose it is. */
  graspAt(tool: Pose): (Goal & { name: string }) | null {
    return nearest(tool, this.grasps());
  }

  /** Return the step that puts what the tool holds where it is; null where that is no place for it. */
  stepAt(tool: Pose): TaskStep | null {
    const { held } = this;
    if (!held) return null;
    const pose = product(tool, held.pose);
    pose[11]! -= this.letGo;
    return stepFor(held.facts, pose, this.around);
  }

  private get around(): Around {
    return { plate: this.plate, table: this.table, lying: this.all.filter((one) => !one.held) };
  }

  /** Return the name of an object that stands on that one; empty if there is none. */
  above(name: string): string {
    const { all } = this,
      one = all.find(({ facts }) => facts.name === name);
    return (one && all.find((other) => other !== one && !other.held && standsOn(other, one))?.facts.name) ?? "";
  }

  /** Return where the tool would be to grasp an object, or to put down the one that it holds: the nearest goal. */
  goal(tool: Pose): Goal | null {
    const { held } = this;
    return nearest(tool, held ? this.placesFor(held, tool) : this.grasps());
  }

  private grasps(): (Goal & { name: string })[] {
    return this.all.flatMap(({ facts, pose }) =>
      (facts.grasps ?? []).flatMap((grasp) =>
        alike(pose, facts.turns).map((at) => ({
          pose: product(at, grasp),
          what: gettext("the grasp of {object}", { object: translate(facts.name) }),
          name: facts.name,
        })),
      ),
    );
  }

  private placesFor(held: KnownObject, tool: Pose): Goal[] {
    const inHand = inverse(held.pose),
      { facts } = held,
      first = facts.first && [
        { at: Float64Array.from(facts.first), what: gettext("where {object} was first", { object: translate(facts.name) }) },
      ];
    return [...this.built(facts), ...this.tops(held), ...(first ?? []), ...this.studs(held, tool)].flatMap(({ at, what }) =>
      alike(at, facts.turns).map((turned) => ({ pose: product(turned, inHand), what })),
    );
  }

  /** Return where an object belongs in a figure, once what is beneath it is there. */
  private built(facts: ObjectFacts): { at: Float64Array; what: string }[] {
    return this.goals
      .flatMap(({ kind, parts }) => (kind === "build" ? parts : []))
      .filter(({ object, pose }) => object === facts.name && stepFor(facts, pose, this.around))
      .map(({ pose }) => ({ at: raised(Float64Array.from(pose), this.letGo), what: gettext("its place in the figure") }));
  }

  /** Return the place on the studs of the plate that is nearest to what the tool holds. */
  private studs({ facts, pose }: KnownObject, tool: Pose): { at: Float64Array; what: string }[] {
    const near = this.plate && nearestStud(this.plate, facts, product(tool, pose));
    return near
      ? [
          {
            at: raised(near.at, this.letGo),
            what: gettext("the studs at column {column}, row {row}", { column: near.stud[0], row: near.stud[1] }),
          },
        ]
      : [];
  }

  /** Return the free tops of objects that may carry the one that is held. */
  private tops({ facts }: KnownObject): { at: Float64Array; what: string }[] {
    const lying = this.all.filter(({ held }) => !held);
    return lying
      .filter((one) => isUpright(one.pose))
      .filter((one) => (one.facts.carries ?? []).some((name) => name === "*" || name === facts.name))
      .filter((one) => !lying.some((other) => other !== one && standsOn(other, one)))
      .map(({ facts: below, pose }) => {
        const height = pose[11]! + (below.size[2] + facts.size[2]) / 2 + this.letGo;
        return {
          at: uprightAt([pose[3]!, pose[7]!, height], yawOf(pose)),
          what: gettext("on {object}", { object: translate(below.name) }),
        };
      });
  }
}

/** Return the nearest goal; of goals that are as good as at one place, the first. */
function nearest<One extends Goal>(tool: Pose, goals: readonly One[]): One | null {
  return goals.reduce<One | null>((best, one) => (!best || cost(tool, one.pose) < cost(tool, best.pose) - SAME_M ? one : best), null);
}

function raised(pose: Float64Array, by: number): Float64Array {
  pose[11]! += by;
  return pose;
}

/** Return the goal's pose if the tool is near it, else the pose itself. */
export function snapped(pose: Float64Array, goal: Goal | null): Float64Array {
  const far = goal && distance(pose, goal.pose);
  return goal && far!.m <= SNAP_M && far!.rad <= SNAP_RAD ? goal.pose : pose;
}

/** As `snapped`, but a step that leaves a goal does not snap back to it. */
export function snappedStep(pose: Float64Array, goal: Goal | null, from: Pose | null): Float64Array {
  if (goal && from && cost(from, goal.pose) <= cost(pose, goal.pose)) return pose;
  return snapped(pose, goal);
}

/** Return what is missing to a goal, in words. */
export function missingInWords(pose: Pose, goal: Goal): string {
  const { pose: at, what } = goal;
  return isSaidAt(pose, goal)
    ? gettext("The ghost is at {place}.", { place: what })
    : gettext("To {place}: {way}.", { place: what, way: wayInWords(pose, at) });
}

/** Whether words say that a pose is at a goal: less is missing than they tell. */
export function isSaidAt(pose: Pose, goal: Goal): boolean {
  return wayInWords(pose, goal.pose) === "";
}

function standsOn(upper: KnownObject, lower: KnownObject): boolean {
  const gap = upper.pose[11]! - upper.facts.size[2] / 2 - (lower.pose[11]! + lower.facts.size[2] / 2),
    aside = Math.hypot(upper.pose[3]! - lower.pose[3]!, upper.pose[7]! - lower.pose[7]!);
  return Math.abs(gap) < ALONE_M && aside < (Math.max(...upper.facts.size) + Math.max(...lower.facts.size)) / 2;
}

function beliefsIn(data: Uint8Array): { objects: Record<string, { how?: unknown; at_ms?: unknown }>; goals: unknown } | null {
  try {
    const read = JSON.parse(new TextDecoder().decode(data)) as { objects?: unknown; goals?: unknown } | null,
      objects = read?.objects;
    return typeof objects === "object" && objects !== null
      ? { objects: objects as Record<string, { how?: unknown }>, goals: read?.goals }
      : null;
  } catch {
    return null;
  }
}
