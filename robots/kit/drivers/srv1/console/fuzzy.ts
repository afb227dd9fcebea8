/** The speed for two readings by a rule set, as in robots/kit/rovers/fuzzy.py. SI units. */
export const TERMS = 5;
export type Method = "sugeno" | "mamdani";
/** A reading or the speed: its five terms, each with its label and where it has its peak. */
export interface Variable {
  name: string;
  unit: string;
  labels: string[];
  peaks: number[];
}
/** `table[first][second]` is the number of a term of the output; -1 where a pair has no rule. */
export interface RuleSet {
  method: Method;
  inputs: [Variable, Variable];
  output: Variable;
  table: number[][];
}

/** Return the pairs that count for two readings, at most four, with how much each fires. */
export function firing(rules: RuleSet, first: number, second: number): [i: number, j: number, weight: number][] {
  const [i, s] = place(rules.inputs[0].peaks, first),
    [j, t] = place(rules.inputs[1].peaks, second);
  const found: [number, number, number][] = [];
  for (const m of [0, 1])
    for (const n of [0, 1]) {
      const weight = Math.min(m ? s : 1 - s, n ? t : 1 - t);
      if (weight > 0) found.push([i + m, j + n, weight]);
    }
  return found;
}

/** Return the speed for two readings; NaN where a pair that counts has no rule. */
export function speed(rules: RuleSet, first: number, second: number): number {
  const fired = firing(rules, first, second).map(([i, j, weight]): [number, number] => [weight, rules.table[i]?.[j] ?? -1]);
  if (fired.some(([, term]) => term < 0)) return NaN;
  return rules.method === "mamdani" ? centroid(rules.output.peaks, fired) : mean(rules.output.peaks, fired);
}

function mean(peaks: readonly number[], fired: readonly [number, number][]): number {
  return fired.reduce((sum, [weight, term]) => sum + weight * peaks[term]!, 0) / fired.reduce((sum, [weight]) => sum + weight, 0);
}

/** The centroid of the clipped triangles' union; the outer two have equal sides. */
function centroid(peaks: readonly number[], fired: readonly [number, number][]): number {
  const clipped = Array.from({ length: TERMS + 2 }, () => 0); // with one that never fires on either side
  for (const [weight, term] of fired) clipped[term + 1] = Math.max(clipped[term + 1]!, weight);
  const ends = [2 * peaks[0]! - peaks[1]!, ...peaks, 2 * peaks[TERMS - 1]! - peaks[TERMS - 2]!];
  let area = 0,
    moment = 0;
  for (let n = 0; n <= TERMS; n++) {
    if (!clipped[n] && !clipped[n + 1]) continue;
    const [size, centre] = union(clipped[n]!, clipped[n + 1]!),
      width = ends[n + 1]! - ends[n]!;
    area += width * size;
    moment += width * (size * ends[n]! + width * centre);
  }
  return moment / area;
}

/** Area and first moment, from 0 to 1, below a falling and a rising side that are clipped. */
function union(falling: number, rising: number): [number, number] {
  const corners = [0, 1 - falling, 1 - rising, falling, rising, 1].sort((a, b) => a - b);
  const height = (x: number): number => Math.max(Math.min(falling, 1 - x), Math.min(rising, x));
  let area = 0,
    moment = 0;
  for (let n = 0; n + 1 < corners.length; n++) {
    const a = corners[n]!,
      b = corners[n + 1]!,
      f = height(a),
      g = height(b);
    area += ((b - a) * (f + g)) / 2;
    moment += ((b - a) * (f * (2 * a + b) + g * (a + 2 * b))) / 6;
  }
  return [area, moment];
}

/** The term at or below a reading, and the membership of the next one; its own is the rest to 1. */
function place(peaks: readonly number[], reading: number): [number, number] {
  if (!(reading > peaks[0]!)) return [0, 0];
  if (reading >= peaks[TERMS - 1]!) return [TERMS - 2, 1];
  const n = peaks.filter((peak) => peak <= reading).length - 1;
  return [n, (reading - peaks[n]!) / (peaks[n + 1]! - peaks[n]!)];
}
