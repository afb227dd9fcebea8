/**
 * Singular poses, at which joints can turn against each other while the tool stands still (robots/kit/arms/singular.py).
 *
 * A closed form gives only one of many answers there, or an approximate one. It is moved onto the pose, and from there
 * along the ways in which the tool does not move.
 */
import type { Chain, Joints, Pose } from "./chain.ts";
import { apart, decomposed, leastValue, missing, product, type Singular, solved } from "./linear.ts";
import { EVEN_S, nearestOf } from "./nearest.ts";

const EXACT = 1e-9; // m and rad
const SLACK_RAD = 1e-9;
const TURNS = [-2, -1, 0, 1, 2]; // whole turns that may lie inside the limits of two joints together
const POLISH = 8; // steps of Gauss and Newton
const SAME = 1e-7; // tolerance of the pose while joints turn against each other (m and rad)
const TRIED = 0.01; // rad: so far the tool must stand still along a way that is free
const SINGULAR = 1e-4; // least singular value of the Jacobian (m and rad),
const ABOUT = 1e-2; // of an approximate answer

/** Return whether joints, which may be approximate, can belong to a singular pose. */
export function aboutSingular(chain: Chain, q: Joints): boolean {
  const jacobian = chain.jacobian(q);
  return !(leastValue(jacobian) > ABOUT) && !(decomposed(jacobian).values.at(-1)! > ABOUT);
}

/**
 * Return joints inside the limits that put the tool at `pose`, found from the singular answer `q`: of those between which
 * the joints turn against each other in proportion, the nearest to `near`. Null if none is inside.
 */
export function nearestShare(chain: Chain, q: Joints, pose: Pose, near: Joints): number[] | null {
  const begin = polished(chain, q, pose);
  if (!begin) return null;
  const { values, ways } = decomposed(chain.jacobian(begin)),
    still = ways.filter((_, k) => values[k]! <= SINGULAR),
    there = chain.forward(begin);
  // of several, some may be free for a moment only, as a stretched elbow is: it bends, and the tool comes nearer
  const free = still.length > 1 ? apart(still).filter((way) => same(chain.forward(along(begin, way, TRIED)), there)) : still;
  const ends = free.length ? TURNS.map((turn) => moved(chain, begin, free, near, turn)) : [];
  const found = ends.filter((end) => end !== null && same(chain.forward(end), there)) as number[][];
  return nearestOf(chain, chain.brokenLimit(begin) ? found : [...found, begin], near);
}

function same(a: Pose, b: Pose): boolean {
  for (let i = 0; i < 12; i++) if (!(Math.abs(a[i]! - b[i]!) < SAME)) return false;
  return true;
}

/**
 * Return `q` moved onto the pose by a few steps of Gauss and Newton; null if they do not converge.
 *
 * Ways in which the tool hardly moves, by their share of the greatest singular value, are left alone.
 */
export function polished(chain: Chain, q: Joints, pose: Pose, least = 1e-6): number[] | null {
  let here = Array.from(q);
  for (let step = 0; step < POLISH; step++) {
    const off = missing(chain.forward(here), pose);
    if (off.every((part) => Math.abs(part) < EXACT)) return here;
    const change: number[] = solved(decomposed(chain.jacobian(here)), off, least);
    here = here.map((value, n) => value + change[n]!);
  }
  return null;
}

/** Return `q`, with whole turns added, moved along the free ways into the limits and as near to `near` as it goes; null if not inside. */
function moved(chain: Chain, q: readonly number[], free: Singular["ways"], near: Joints, turn: number): number[] | null {
  const first = free[0]!.map(Math.abs),
    turning = first.indexOf(Math.max(...first));
  let here = q.map((value, n) => value + (n === turning ? 2 * Math.PI * turn : 0));
  const gap = here.map((value, n) => near[n]! - value);
  for (const way of free) here = along(here, way, product(way, gap));
  for (const way of free) {
    const range = room(chain, here, way);
    if (!range) return null;
    here = along(here, way, bestShare(chain, here, way, near, range));
  }
  if (chain.brokenLimit(here, 1e-6)) return null;
  return here.map((value, n) => Math.min(Math.max(value, chain.joints[n]!.low), chain.joints[n]!.high));
}

function along(q: readonly number[], way: readonly number[], share: number): number[] {
  return q.map((value, n) => value + way[n]! * share);
}

/** Return how far `q` may go along a way, from where to where; null if it is nowhere inside the limits. */
function room(chain: Chain, q: readonly number[], way: readonly number[]): [number, number] | null {
  let first = -Infinity,
    last = Infinity;
  for (const [n, { low, high }] of chain.joints.entries()) {
    if (!(Math.abs(way[n]!) > 1e-6)) continue;
    const a = (low - q[n]!) / way[n]!,
      b = (high - q[n]!) / way[n]!;
    first = Math.max(first, Math.min(a, b));
    last = Math.min(last, Math.max(a, b));
  }
  return first > last + SLACK_RAD ? null : [first, last];
}

/**
 * Return how far along a way the joints are nearest to `near`. The slowest joint's time is the greatest of lines over the
 * way: it is least at an end, or where two meet. Where that leaves a choice, the squares of all times decide.
 */
function bestShare(chain: Chain, q: readonly number[], way: readonly number[], near: Joints, [first, last]: [number, number]): number {
  const off = q.map((value, n) => (value - near[n]!) / chain.joints[n]!.velocity),
    pace = way.map((value, n) => value / chain.joints[n]!.velocity);
  const lines = [...off.map((v, n) => [v, pace[n]!] as const), ...off.map((v, n) => [-v, -pace[n]!] as const)];
  const tried = [first, last, -product(off, pace) / product(pace, pace)];
  for (const [a, slope] of lines) for (const [b, other] of lines) if (Math.abs(slope - other) > 1e-9) tried.push((b - a) / (slope - other));
  const shares = tried.map((share) => Math.min(Math.max(share, first), last));
  const slowest = shares.map((share) => Math.max(...lines.map(([a, slope]) => a + slope * share)));
  const squares = shares.map((share) => off.reduce((sum, v, n) => sum + (v + pace[n]! * share) ** 2, 0));
  const least = Math.min(...slowest);
  let best = -1;
  for (const [k, time] of slowest.entries()) if (time <= least + EVEN_S && (best < 0 || squares[k]! < squares[best]!)) best = k;
  return shares[best] ?? first;
}
