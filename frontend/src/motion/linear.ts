/** Linear algebra of a Jacobian, given as columns of six numbers. */
import type { Pose } from "./chain.ts";

/** Singular values of a Jacobian, the greatest first, with the joint speeds of each and where they move the tool. */
export interface Singular {
  values: number[];
  ways: number[][]; // n numbers each, of unit length
  moves: number[][]; // the Jacobian times each way: its length is the singular value
}

const SWEEPS = 30; // at most; about six are needed
const SMALL = 1e-15;

/**
 * Return the singular value decomposition of the matrix with these columns of six numbers.
 *
 * One-sided Jacobi (Hestenes 1958; Golub and Van Loan 1996, section 8.6.3): pairs of columns are turned until all are at
 * right angles to each other. It is exact for the smallest values, too, which are those that are needed here.
 */
export function decomposed(columns: Float64Array): Singular {
  const n = columns.length / 6,
    a = Array.from({ length: n }, (_, i) => [...columns.subarray(6 * i, 6 * i + 6)]),
    v = a.map((_, i) => Array.from({ length: n }, (_, k) => (k === i ? 1 : 0)));
  for (let sweep = 0, again = true; again && sweep < SWEEPS; sweep++) {
    again = false;
    for (let i = 0; i < n - 1; i++)
      for (let k = i + 1; k < n; k++) {
        const between = product(a[i]!, a[k]!),
          left = product(a[i]!, a[i]!),
          right = product(a[k]!, a[k]!);
        if (!(Math.abs(between) > SMALL * Math.sqrt(left * right))) continue;
        again = true;
        const zeta = (right - left) / (2 * between),
          t = (zeta < 0 ? -1 : 1) / (Math.abs(zeta) + Math.sqrt(1 + zeta * zeta));
        turn(a[i]!, a[k]!, t);
        turn(v[i]!, v[k]!, t);
      }
  }
  const sizes = a.map((column) => Math.sqrt(product(column, column)));
  const order = sizes.map((_, i) => i).sort((i, k) => sizes[k]! - sizes[i]!);
  return { values: order.map((i) => sizes[i]!), ways: order.map((i) => v[i]!), moves: order.map((i) => a[i]!) };
}

/**
 * Return a lower bound of the smallest singular value of the square matrix with these columns of six numbers, from its
 * determinant and the sum of its squares (Yu and Gu 1997). It is much quicker than the decomposition.
 */
export function leastValue(columns: Float64Array): number {
  const a = columns.slice();
  let determinant = 1,
    squares = 0;
  for (const value of columns) squares += value * value;
  for (let k = 0; k < 6; k++) {
    let pivot = k;
    for (let i = k + 1; i < 6; i++) if (Math.abs(a[6 * i + k]!) > Math.abs(a[6 * pivot + k]!)) pivot = i;
    const size = a[6 * pivot + k]!;
    determinant *= Math.abs(size);
    if (!(determinant > 0)) return 0;
    for (let j = k; j < 6; j++) [a[6 * k + j], a[6 * pivot + j]] = [a[6 * pivot + j]!, a[6 * k + j]!];
    for (let i = k + 1; i < 6; i++) {
      const share = a[6 * i + k]! / size;
      for (let j = k; j < 6; j++) a[6 * i + j]! -= share * a[6 * k + j]!;
    }
  }
  return determinant * (5 / squares) ** 2.5;
}

export function product(a: readonly number[], b: readonly number[]): number {
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += a[i]! * b[i]!;
  return sum;
}

/** Turn two vectors in their plane by the angle with the tangent `t`. */
function turn(a: number[], b: number[], t: number): void {
  const c = 1 / Math.sqrt(1 + t * t),
    s = c * t;
  for (let i = 0; i < a.length; i++) {
    const x = a[i]!,
      y = b[i]!;
    a[i] = c * x - s * y;
    b[i] = s * x + c * y;
  }
}

/**
 * Return ways that together lead to the same places as the given ones, each through as few joints as possible (reduced
 * row echelon form): at a stretched elbow with a straight wrist, one of the elbow and one of the wrist.
 */
export function apart(ways: readonly number[][]): number[][] {
  const rows = ways.map((way) => [...way]);
  for (const row of rows) {
    const pivot = row.reduce((best, value, n) => (Math.abs(value) > Math.abs(row[best]!) ? n : best), 0);
    for (const other of rows) {
      const share = other[pivot]! / row[pivot]!;
      if (other !== row) for (let n = 0; n < row.length; n++) other[n]! -= share * row[n]!;
    }
  }
  return rows.map((row) => row.map((value) => value / Math.hypot(...row)));
}

/** Return the smallest joint speeds with the tool's velocity `wanted`, without ways whose value is below `least` of the greatest. */
export function solved({ values, ways, moves }: Singular, wanted: readonly number[], least: number): number[] {
  const speeds = ways.map(() => 0);
  for (const [k, value] of values.entries()) {
    if (!(value > least * values[0]!)) continue;
    const share = product(moves[k]!, wanted) / (value * value);
    for (let i = 0; i < speeds.length; i++) speeds[i]! += share * ways[k]![i]!;
  }
  return speeds;
}

/** Return what is missing from pose `from` to pose `to`: three lengths (m), and the turn as axis times angle (rad), in the base's frame. */
export function missing(from: Pose, to: Pose): number[] {
  const r = (i: number, k: number): number =>
    to[4 * i]! * from[4 * k]! + to[4 * i + 1]! * from[4 * k + 1]! + to[4 * i + 2]! * from[4 * k + 2]!;
  return [to[3]! - from[3]!, to[7]! - from[7]!, to[11]! - from[11]!, ...turnOf(quaternionOf(r))];
}

/** Return the quaternion (x, y, z, w; unit length) of a rotation, given by row and column (Shepperd 1978). */
export function quaternionOf(r: (row: number, column: number) => number): number[] {
  const trace = r(0, 0) + r(1, 1) + r(2, 2),
    greatest = Math.max(r(0, 0), r(1, 1), r(2, 2), trace);
  const q = [r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1), 1 + trace];
  if (greatest !== trace) {
    const i = [0, 1, 2].find((k) => r(k, k) === greatest) ?? 0,
      k = (i + 1) % 3,
      l = (i + 2) % 3;
    q[3] = r(l, k) - r(k, l);
    q[i] = 1 - trace + 2 * r(i, i);
    q[k] = r(k, i) + r(i, k);
    q[l] = r(l, i) + r(i, l);
  }
  const size = Math.hypot(...q);
  return q.map((part) => part / size);
}

/** Return the rotation of a quaternion as axis times angle (rad), by half a turn at most. */
export function turnOf(quaternion: readonly number[]): number[] {
  const [x = 0, y = 0, z = 0, w = 1] = quaternion,
    sine = Math.hypot(x, y, z),
    angle = 2 * Math.atan2(w < 0 ? -sine : sine, Math.abs(w));
  const share = sine > 1e-12 ? angle / sine : w < 0 ? -2 : 2;
  return [x * share, y * share, z * share];
}
