/** Which of several joint vectors is the nearest: the one whose slowest joint has the shortest way. */
import type { Chain, Joints } from "./chain.ts";

export const EVEN_S = 1e-12; // answers that differ by less are equally near

/** How far joints are from others: the time of the slowest joint at full speed (s), and the sum of squares of all (s2). */
export interface Cost {
  slowest: number;
  squares: number;
}

export function cost(chain: Chain, q: Joints, near: Joints): Cost {
  let slowest = 0,
    squares = 0;
  for (const [n, { velocity }] of chain.joints.entries()) {
    const way = Math.abs(q[n]! - near[n]!) * (1 / velocity);
    if (way > slowest) slowest = way;
    squares += way * way;
  }
  return { slowest, squares };
}

/** Return whether an answer is nearer than the best so far; of equally near ones, the one whose other joints move less. */
export function nearer(a: Cost, b: Cost | null): boolean {
  if (!b || a.slowest < b.slowest - EVEN_S) return true;
  return a.slowest <= b.slowest + EVEN_S && a.squares < b.squares;
}

/** Return the nearest of the answers; null if there are none. */
export function nearestOf(chain: Chain, answers: Iterable<number[]>, near: Joints): number[] | null {
  let best: number[] | null = null,
    least: Cost | null = null;
  for (const q of answers) {
    const found = cost(chain, q, near);
    if (nearer(found, least)) [best, least] = [q, found];
  }
  return best;
}
