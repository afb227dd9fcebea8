/**
 * Forbidden boxes: where the arm's limbs must not be (robots/kit/arms/zones.py). Each limb is a capsule: a segment with a
 * radius.
 */
import { type Chain, FRAME, type Joints } from "./chain.ts";
import type { BoxFacts, LimbFacts } from "./facts.ts";
import { atLeast, exactly } from "./segments.ts";

export const SLACK_M = 1e-7;

/** A limb and the box that it is in, or nearest to, with the distance between their surfaces (m; negative inside). */
export interface Touch {
  limb: string;
  box: string;
  distance: number;
}

export function inWords({ limb, box }: Touch): string {
  return `the ${limb} would enter ${box}`;
}

interface Pair {
  limb: number;
  box: BoxFacts;
  radius: number;
}

export class Zones {
  private readonly chain: Chain;
  private readonly limbs: readonly LimbFacts[];
  private readonly pairs: readonly Pair[];
  private readonly arms: readonly number[][]; // of each limb: how far (m) a point of it can be from each joint's axis
  private readonly frames: Float64Array;
  private readonly ends: Float64Array; // of the limbs, six numbers each

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

  /** Return lower bounds of the distances, which are quicker. */
  lowerBounds(q: Joints): Float64Array {
    return this.measured(q, atLeast);
  }

  private measured(q: Joints, measure: typeof exactly): Float64Array {
    this.place(q);
    const { pairs, ends } = this,
      found = new Float64Array(pairs.length);
    for (let k = 0; k < pairs.length; k++) {
      const { limb, box, radius } = pairs[k]!;
      found[k] = measure(ends, 6 * limb, box) - radius;
    }
    return found;
  }

  /** Write the ends of the limbs for these joints. */
  private place(q: Joints): void {
    const { frames, ends, limbs } = this;
    this.chain.frames(q, frames);
    for (let n = 0; n < limbs.length; n++) {
      const { joint, begin, end } = limbs[n]!;
      for (let row = 0; row < 3; row++) {
        const at = FRAME * joint + 4 * row,
          to = 6 * n + row;
        ends[to] = frames[at]! * begin[0]! + frames[at + 1]! * begin[1]! + frames[at + 2]! * begin[2]! + frames[at + 3]!;
        ends[to + 3] = frames[at]! * end[0]! + frames[at + 1]! * end[1]! + frames[at + 2]! * end[2]! + frames[at + 3]!;
      }
    }
  }

  /** Return how fast (m/s) the limb of each pair can move at most, with joints at these speeds (rad/s). */
  speeds(joints: Joints): Float64Array {
    const ofLimbs = this.arms.map((arms) => arms.reduce((sum, arm, n) => sum + arm * joints[n]!, 0));
    return Float64Array.from(this.pairs, ({ limb }) => ofLimbs[limb]!);
  }

  /** Return quickly whether nothing is touched for certain; false may mean either. */
  clear(q: Joints): boolean {
    return this.lowerBounds(q).every((distance) => distance >= 0);
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

  /** Return the pair that is deepest inside a box, of those deeper than `floor` allows; null if none is. */
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
}

/** Return for each joint how far (m) a point of the limb can be from its axis at most; 0 if it does not move it. */
function reaches(chain: Chain, { joint, begin, end, radius }: LimbFacts, clearance: number): number[] {
  const size = (v: readonly number[]): number => Math.hypot(v[0]!, v[1]!, v[2]!),
    reach = Math.max(size(begin), size(end)) + radius + clearance;
  const lengths = chain.joints.map(({ origin }) => size([origin[3]!, origin[7]!, origin[11]!]));
  return lengths.map((_, i) => (i <= joint ? lengths.slice(i + 1, joint + 1).reduce((sum, length) => sum + length, reach) : 0));
}
