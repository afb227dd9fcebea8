/** Distances of segments to axis-aligned boxes (robots/kit/arms/segments.py); m. */

/** The corners of a box. */
export interface Box {
  low: readonly number[];
  high: readonly number[];
}

/**
 * Return a lower bound of the distance of a segment to a box: that of the smallest box around the segment. `ends`: the
 * six numbers of its ends from `at` on.
 */
export function atLeast(ends: Float64Array, at: number, { low, high }: Box): number {
  let sum = 0;
  for (let k = 0; k < 3; k++) {
    const a = ends[at + k]!,
      b = ends[at + 3 + k]!,
      gap = Math.max(low[k]! - Math.max(a, b), Math.min(a, b) - high[k]!);
    if (gap > 0) sum += gap * gap;
  }
  return Math.sqrt(sum);
}

const cuts = new Float64Array(8); // shared by all calls, which do not overlap

/**
 * Return the distance of a segment to a box. The squared distance to a convex box is convex along the segment, and its
 * slope is linear between the places where the segment crosses the plane of a face: so the least distance is where the
 * slope crosses zero, between two such places.
 */
export function exactly(ends: Float64Array, at: number, box: Box): number {
  const count = crossings(ends, at, box);
  let before = slope(ends, at, box, 0),
    first = 0;
  if (before >= 0) return offBox(ends, at, box, 0);
  for (let n = 0; n < count; n++) {
    const then = cuts[n]!,
      after = slope(ends, at, box, then);
    if (after >= 0) return offBox(ends, at, box, first + (-before / (after - before)) * (then - first));
    before = after;
    first = then;
  }
  return offBox(ends, at, box, 1);
}

/** Write into `cuts`, in order, where the segment crosses the faces' planes between its ends, and its end; return how many. */
function crossings(ends: Float64Array, at: number, { low, high }: Box): number {
  let count = 0;
  for (let k = 0; k < 6; k++) {
    const a = ends[at + (k % 3)]!,
      t = ((k < 3 ? low : high)[k % 3]! - a) / (ends[at + 3 + (k % 3)]! - a);
    if (!(t > 0 && t < 1)) continue;
    let n = count++;
    for (; n > 0 && cuts[n - 1]! > t; n--) cuts[n] = cuts[n - 1]!;
    cuts[n] = t;
  }
  cuts[count] = 1;
  return count + 1;
}

/** Return half the slope of the squared distance at a share of the segment. */
function slope(ends: Float64Array, at: number, { low, high }: Box, share: number): number {
  let sum = 0;
  for (let k = 0; k < 3; k++) {
    const way = ends[at + 3 + k]! - ends[at + k]!,
      x = ends[at + k]! + share * way;
    sum += (x < low[k]! ? x - low[k]! : x > high[k]! ? x - high[k]! : 0) * way;
  }
  return sum;
}

function offBox(ends: Float64Array, at: number, { low, high }: Box, share: number): number {
  let sum = 0;
  for (let k = 0; k < 3; k++) {
    const x = ends[at + k]! + share * (ends[at + 3 + k]! - ends[at + k]!),
      off = x < low[k]! ? x - low[k]! : x > high[k]! ? x - high[k]! : 0;
    sum += off * off;
  }
  return Math.sqrt(sum);
}
