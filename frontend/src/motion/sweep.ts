/** The first touch on a path (`swept` of robots/kit/arms/zones.py): the whole path is checked before it starts. */
import { type Budget, GLANCED_AT, LOOK, LOOKED_AT } from "./budget.ts";
import type { Cubic } from "./path.ts";
import { SLACK_M, type Touch, Zones } from "./zones.ts";

const FINEST_S = 0.002; // two checked postures are never closer than one step of a controller,
const FINEST_M = 0.001; // nor closer than this much of the arm's motion
const FIRST_M = 0.15; // of the arm's motion between two postures of the first check
const FIRST = 64; // postures: at most in the first check,
const MOST = 256; // at most at once

/** A posture on the path: its time, and the distance of each pair, or a lower bound of it. */
interface Posture {
  t: number;
  distances: Float64Array;
  least: number;
  exact: boolean;
}

/**
 * Return the time (s) and pair of the first touch on the path, null if it is free. Checks postures along the whole path,
 * then more between two of them where a limb at its greatest speed could have reached a box and returned, so that no thin
 * box is missed. Throws Refused: that needs more checks than the budget allows.
 */
export function swept(zones: Zones, path: Cubic, budget: Budget): { seconds: number; touch: Touch } | null {
  const speeds = zones.speeds(path.fastest()),
    fastest = Math.max(1e-6, ...speeds),
    finest = Math.max(FINEST_S, FINEST_M / fastest);
  let postures = glanced(zones, path, Math.min(FIRST, 2 + Math.trunc((fastest * path.seconds) / FIRST_M)), budget);
  for (;;) {
    const floors = floorsOf(postures),
      hit = postures.findIndex((posture, i) => isInside(posture, floors[i]!)),
      last = hit < 0 ? postures.length - 1 : hit;
    const unsure: number[] = [];
    for (let i = 0; i < last; i++) {
      const gap = postures[i + 1]!.t - postures[i]!.t;
      if (gap > finest && couldTouch(postures[i]!, postures[i + 1]!, floors[i]!, speeds, gap, fastest)) unsure.push(i);
    }
    const doubted = new Set([...unsure, ...unsure.map((i) => i + 1), last]);
    if (hit < 0 && unsure.at(-1) !== last - 1) doubted.delete(last);
    const again = [...doubted].map((i) => postures[i]!).filter(({ exact }) => !exact);
    if (again.length) {
      look(zones, path, again, budget);
      continue;
    }
    if (!unsure.length) {
      const touch = hit < 0 ? null : zones.entered(postures[hit]!.distances, floors[hit]!);
      return touch && { seconds: postures[hit]!.t, touch };
    }
    postures = between(zones, path, postures, new Set(unsure.slice(0, MOST)), budget);
  }
}

/**
 * Return so many postures at equal times with lower bounds of their distances. If a limb starts inside a box all are
 * exact, because its depth decides how deep it may stay.
 */
function glanced(zones: Zones, path: Cubic, count: number, budget: Budget): Posture[] {
  budget.spend(LOOK + GLANCED_AT * count);
  const step = path.seconds / (count - 1),
    inside = Math.min(0, ...zones.distances(path.sample(0))) < 0;
  return Array.from({ length: count }, (_, n) => {
    const t = n === count - 1 ? path.seconds : n * step,
      q = path.sample(t);
    if (inside) return posture(t, zones.distances(q), true);
    const bounds = zones.lowerBounds(q);
    return posture(t, n ? bounds : bounds.map((distance) => Math.max(distance, 0)), false);
  });
}

function posture(t: number, distances: Float64Array, exact: boolean): Posture {
  return { t, distances, least: Math.min(Infinity, ...distances), exact };
}

function look(zones: Zones, path: Cubic, postures: Posture[], budget: Budget): void {
  budget.spend(LOOK + LOOKED_AT * postures.length);
  for (const one of postures) Object.assign(one, posture(one.t, zones.distances(path.sample(one.t)), true));
}

/** Return the postures with one more in the middle after each of `after`. */
function between(zones: Zones, path: Cubic, postures: Posture[], after: Set<number>, budget: Budget): Posture[] {
  const found: Posture[] = [],
    more: Posture[] = [];
  for (const [i, one] of postures.entries()) {
    found.push(one);
    if (!after.has(i)) continue;
    const middle = posture(one.t + (postures[i + 1]!.t - one.t) / 2, new Float64Array(0), false);
    found.push(middle);
    more.push(middle);
  }
  look(zones, path, more, budget);
  return found;
}

/** Return how deep inside each pair may be at each posture, after those before it: it may only move away. */
function floorsOf(postures: Posture[]): Float64Array[] {
  let deepest = Zones.floor(postures[0]!.distances);
  const outside = postures[0]!.least >= 0; // then nothing may be inside at any time
  return postures.map(({ distances }) => {
    const floor = deepest;
    if (outside) return floor;
    let raised: Float64Array | null = null;
    for (let k = 0; k < floor.length; k++) {
      const depth = Math.min(distances[k]!, 0);
      if (depth > floor[k]!) (raised ??= floor.slice())[k] = depth;
    }
    deepest = raised ?? floor;
    return floor;
  });
}

function isInside({ distances, least }: Posture, floor: Float64Array): boolean {
  if (least >= -SLACK_M) return false; // no floor is above zero
  for (let k = 0; k < distances.length; k++) if (distances[k]! < floor[k]! - SLACK_M) return true;
  return false;
}

/** Return whether a limb could have been inside a box between two postures. */
function couldTouch(a: Posture, b: Posture, floor: Float64Array, speeds: Float64Array, gap: number, fastest: number): boolean {
  if (a.least + b.least - gap * fastest >= 0) return false;
  for (let k = 0; k < speeds.length; k++) {
    const here = a.distances[k]!,
      lowest = (here + b.distances[k]! - gap * speeds[k]!) / 2;
    if (lowest < Math.max(floor[k]!, Math.min(here, 0)) - SLACK_M) return true;
  }
  return false;
}
