/** What can be won with an arm's objects: where each part of a figure belongs, and what is missing, in words. */
import type { Pose } from "../motion/chain.ts";
import { cost, wayInWords } from "./moves.ts";
import type { KnownObject } from "./known.ts";
import { alike } from "./poses.ts";
import { gettext, translate } from "../kit/text.ts";

/** A goal as `goal_facts` of robots/kit/arms/goals.py tells it: poses 4 x 4 row by row, in the base's frame (m). */
export interface GoalFacts {
  name: string;
  title: string;
  kind: "build" | "lift" | "catch";
  parts: { object: string; pose: number[] }[];
}
/** What the driver has judged: the objects that are there, and when the goal was won (ms since 1970). */
export interface Reached {
  there: readonly string[];
  wonMs: number | null;
}

const NOTHING: Reached = { there: [], wonMs: null };
const MOST = 100; // names of a list

/** Return what a packet of the stream `beliefs` says of the goals, by name. */
export function reachedIn(told: unknown): Record<string, Reached> {
  const goals = typeof told === "object" && told !== null ? Object.entries(told).slice(0, MOST) : [];
  return Object.fromEntries(
    goals.map(([name, one]) => {
      const { there, won_ms } = (one ?? {}) as { there?: unknown; won_ms?: unknown };
      const names = Array.isArray(there) ? there.slice(0, MOST).filter((part) => typeof part === "string") : [];
      return [name, { there: names, wonMs: typeof won_ms === "number" && Number.isFinite(won_ms) ? won_ms : null }];
    }),
  );
}

/** Return the pose at which an object looks as at `goal` that is nearest to where it is. */
export function nearestTurn(goal: Pose, turns: number, from: Pose): Float64Array {
  return alike(goal, turns).reduce((best, one) => (cost(from, one) < cost(from, best) ? one : best));
}

/** Return how far a goal is, as "3 of 5". */
export function progress({ parts }: GoalFacts, reached: Reached = NOTHING): string {
  const count = parts.filter(({ object }) => reached.there.includes(object)).length;
  return gettext("{count} of {total}", { count, total: parts.length });
}

/** Return a line for each part of a figure: done, or what is missing. `objects` are those whose places are known. */
export function partsInWords({ parts }: GoalFacts, objects: readonly KnownObject[], reached: Reached = NOTHING): string[] {
  return parts.map(({ object, pose }) => {
    const name = translate(object);
    if (reached.there.includes(object)) return `✓ ${gettext("{name}: in its place", { name })}`;
    const known = objects.find(({ facts }) => facts.name === object);
    if (!known) return gettext("{name}: nobody knows where it is", { name });
    if (known.held) return gettext("{name}: in the gripper", { name });
    const way = wayInWords(known.pose, nearestTurn(pose, known.facts.turns, known.pose));
    return way ? `${name}: ${way}` : gettext("{name}: almost in its place", { name });
  });
}

/** Return the goals won since `before`, which were told earlier; none at the first time. */
export function newlyWon(goals: readonly GoalFacts[], before: Record<string, Reached> | null, now: Record<string, Reached>): GoalFacts[] {
  if (!before) return [];
  return goals.filter(({ name }) => {
    const { wonMs } = now[name] ?? NOTHING;
    return wonMs !== null && wonMs !== (before[name] ?? NOTHING).wonMs;
  });
}
