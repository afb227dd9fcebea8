/**
 * Forbidden boxes: where the arm's limbs must not go, checked along a whole path before it starts
 * (robots/kit/arms/zones.py). Each limb is a capsule: a segment with a radius.
 */
import { type Budget, GLANCED_AT, LOOK, LOOKED_AT } from "./budget.ts";
import { type Chain, FRAME, type Joints } from "./chain.ts";
import type { BoxFacts, LimbFacts } from "./facts.ts";
import type { Cubic } from "./path.ts";
import { atLeast, exactly } from "./segments.ts";

const SLACK_M = 1e-7;
const FINEST_S = 0.002; // two checked postures are never closer than one step of a controller,
const FINEST_M = 0.001; // nor closer than this much of the arm's motion
const FIRST_M = 0.15; // of the arm's motion between two postures of the first check
const FIRST = 64; // postures: at most in the first check,
const MOST = 256; // at most at once

/** A limb and the box that it is in, or nearest to, with the distance between their surfaces (m; negative inside). */
export interface Touch {
  limb: string;
  box: string;
  distance: number;
}

export function inWords({ limb, box }: Touch): string {
  return `the ${limb} would enter ${box}`;
}

/** A posture on a path: its time, and the distance of each pair, or a lower bound of it. */
interface Posture {
  t: number;
  distances: Float64Array;
  exact: boolean;
}
type Measure = (ends: Float64Array, at: number, box: BoxFacts) => number;

export class Zones {
  private readonly chain: Chain;
  private readonly limbs: readonly LimbFacts[];
  private readonly pairs: readonly { limb: number; box: BoxFacts; radius: number }[];
  private readonly arms: readonly number[][]; // of each limb: how far (m) a point of it can be from each joint's axis
  private readonly frames: Float64Array;
  private readonly ends: Float64Array;

  /** `clearance` (m): so much thicker are the limbs. */
  constructor(chain: Chain, limbs: readonly LimbFacts[], boxes: readonly BoxFacts[], clearance = 0) {
    this.chain = chain;
    this.limbs = limbs;
    this.pairs = limbs.flatMap(({ radius, spared }, limb) =>
      boxes.filter(({ name }) => !spared.includes(name)).map((box) => ({ limb, box, radius: radius + clearance })),
    );
    this.arms = limbs.map((limb) => reaches(chain, limb, clearance));
    this.frames = new Float64Array(FRAME * (chain.count + 1));
    this.ends = new Float64Array(6 * limbs.length);
  }

  /** Return the distance (m) of each pair of limb and box, in the order of the limbs. */
  distances(q: Joints): Float64Array {
    return this.measured(q, exactly);
  }

  private measured(q: Joints, measure: Measure): Float64Array {
    const { frames, ends } = this;
    this.chain.frames(q, frames);
    for (const [n, { joint, begin, end }] of this.limbs.entries())
      for (let row = 0; row < 3; row++) {
        const at = FRAME * joint + 4 * row;
        const [a, b, c, d] = [frames[at]!, frames[at + 1]!, frames[at + 2]!, frames[at + 3]!];
        ends[6 * n + row] = a * begin[0]! + b * begin[1]! + c * begin[2]! + d;
        ends[6 * n + 3 + row] = a * end[0]! + b * end[1]! + c * end[2]! + d;
      }
    return Float64Array.from(this.pairs, ({ limb, box, radius }) => measure(ends, 6 * limb, box) - radius);
  }

  /** Return quickly whether nothing is touched for certain; false may mean either. */
  clear(q: Joints): boolean {
    return this.measured(q, atLeast).every((distance) => distance >= 0);
  }

  /** Return the pair that is nearest to touching, null if there is no box. */
  nearest(q: Joints): Touch | null {
    const distances = this.distances(q);
    return distances.length ? this.touch(distances.indexOf(Math.min(...distances)), distances) : null;
  }

  private touch(which: number, distances: Float64Array): Touch {
    const { limb, box } = this.pairs[which]!;
    return { limb: this.limbs[limb]!.name, box: box.name, distance: distances[which]! };
  }

  /** Return a pair that is deeper inside a box than `floor` allows, the deepest; null if none is. */
  entered(distances: Float64Array, floor: Float64Array): Touch | null {
    let which = -1;
    for (const [k, distance] of distances.entries())
      if (distance < floor[k]! - SLACK_M && (which < 0 || distance < distances[which]!)) which = k;
    return which < 0 ? null : this.touch(which, distances);
  }

  /** Return how deep inside a box each pair may be: as deep as it is now. It may only move away. */
  static floor(distances: Float64Array): Float64Array {
    return distances.map((distance) => Math.min(distance, 0));
  }

  /**
   * Return the time (s) and pair of the first touch on the path, null if it is free. Checks postures along the whole
   * path, then more between two of them where a limb at its greatest speed could have reached a box and returned, so that
   * no thin box is missed. Throws Refused: that needs more checks than the budget allows.
   */
  swept(path: Cubic, budget: Budget): { seconds: number; touch: Touch } | null {
    const fastest = path.fastest(),
      speeds = this.pairs.map(({ limb }) => this.arms[limb]!.reduce((sum, arm, n) => sum + arm * fastest[n]!, 0));
    const greatest = Math.max(1e-6, ...speeds),
      finest = Math.max(FINEST_S, FINEST_M / greatest);
    let postures = this.glanced(path, Math.min(FIRST, 2 + Math.trunc((greatest * path.seconds) / FIRST_M)), budget);
    for (;;) {
      const floors = floorsOf(postures),
        hit = postures.findIndex(({ distances }, i) => distances.some((distance, k) => distance < floors[i]![k]! - SLACK_M));
      const last = hit < 0 ? postures.length - 1 : hit,
        unsure = unsureBefore(last, postures, floors, speeds, finest);
      const doubted = postures.filter(({ exact }, i) => !exact && (unsure.has(i) || unsure.has(i - 1) || i === hit));
      if (doubted.length) {
        this.look(path, doubted, budget);
        continue;
      }
      if (!unsure.size) {
        const { t, distances } = postures[last]!,
          touch = hit < 0 ? null : this.entered(distances, floors[last]!);
        return touch && { seconds: t, touch };
      }
      postures = this.between(path, postures, [...unsure].slice(0, MOST), budget);
    }
  }

  /**
   * Return so many postures at equal times with lower bounds of their distances. If a limb starts inside a box all are
   * exact, because its depth decides how deep it may stay.
   */
  private glanced(path: Cubic, count: number, budget: Budget): Posture[] {
    budget.spend(LOOK + GLANCED_AT * count);
    const step = path.seconds / (count - 1),
      times = Array.from({ length: count }, (_, n) => (n === count - 1 ? path.seconds : n * step));
    const start = this.distances(path.sample(0)),
      inside = start.some((distance) => distance < 0);
    return times.map((t, n) => {
      const distances = this.measured(path.sample(t), inside ? exactly : atLeast);
      return { t, distances: n || inside ? distances : distances.map((distance) => Math.max(distance, 0)), exact: inside };
    });
  }

  private look(path: Cubic, postures: Posture[], budget: Budget): void {
    budget.spend(LOOK + LOOKED_AT * postures.length);
    for (const posture of postures) {
      posture.distances = this.distances(path.sample(posture.t));
      posture.exact = true;
    }
  }

  /** Return the postures with one more in the middle after each of `after`. */
  private between(path: Cubic, postures: Posture[], after: number[], budget: Budget): Posture[] {
    const more = new Map<number, Posture>();
    for (const i of after) {
      const { t } = postures[i]!;
      more.set(i, { t: t + (postures[i + 1]!.t - t) / 2, distances: new Float64Array(0), exact: false });
    }
    this.look(path, [...more.values()], budget);
    return postures.flatMap((posture, i) => [posture, ...(more.has(i) ? [more.get(i)!] : [])]);
  }
}

/** Return how deep inside each pair may be at each posture, after those before it: it may only move away. */
function floorsOf(postures: Posture[]): Float64Array[] {
  const deepest = Zones.floor(postures[0]!.distances);
  return postures.map(({ distances }, i) => {
    const floor = deepest.slice();
    if (i) for (const [k, distance] of distances.entries()) if (Math.min(distance, 0) > deepest[k]!) deepest[k] = Math.min(distance, 0);
    return floor;
  });
}

/** Return the postures before the one of number `last` after which a limb could have been inside until the next. */
function unsureBefore(last: number, postures: Posture[], floors: Float64Array[], speeds: number[], finest: number): Set<number> {
  const found = new Set<number>();
  for (let i = 0; i < last; i++) {
    const here = postures[i]!,
      next = postures[i + 1]!,
      gap = next.t - here.t;
    if (!(gap > finest)) continue;
    const reached = speeds.some((speed, k) => {
      const lowest = (here.distances[k]! + next.distances[k]! - gap * speed) / 2;
      return lowest < Math.max(floors[i]![k]!, Math.min(here.distances[k]!, 0)) - SLACK_M;
    });
    if (reached) found.add(i);
  }
  return found;
}

/** Return for each joint how far (m) a point of the limb can be from its axis at most; 0 if it does not move it. */
function reaches(chain: Chain, { joint, begin, end, radius }: LimbFacts, clearance: number): number[] {
  const size = (v: readonly number[]): number => Math.hypot(v[0]!, v[1]!, v[2]!),
    reach = Math.max(size(begin), size(end)) + radius + clearance;
  const lengths = chain.joints.map(({ origin }) => size([origin[3]!, origin[7]!, origin[11]!]));
  return lengths.map((_, i) => (i <= joint ? lengths.slice(i + 1, joint + 1).reduce((sum, length) => sum + length, reach) : 0));
}
