/** Whether the rover takes a rule set: what robots/kit/rovers/fuzzy.py and fuzzy_check.py refuse, with its place. */
import type { RuleSet, Variable } from "./fuzzy.ts";
import { ruleName } from "./rules_text.ts";

const TERMS = 5,
  MOST = 9999.999,
  SPEEDS = [0, 0.5] as const,
  APART = 0.01;
/** The readings that the rover has, with their units (robots/kit/drivers/srv1/rules.py). */
export const READINGS: Readonly<Record<string, string>> = {
  infrared: "m",
  sonar: "m",
  battery: "V",
  temperature: "C",
  humidity: "%",
  light: "%",
};
const NOISES = 3; // standard deviations of a distance
/** How the rover stops; see `Braking` in fuzzy_check.py. */
export interface Braking {
  deceleration: number;
  reaction: number;
  margin: number;
  stop: number;
  far: number;
  most: number;
}
/** The tables of robot.toml that it comes from. */
export interface Made {
  body: { length: number };
  motion: { acceleration: number; braking: number; forget_s: number; most_speed: number };
  infrared: { from: readonly number[]; noise: number; stop: number; far: number };
}
/** What is wrong. `rule`: the pair of a rule; `variable`: 0 or 1 for an input, 2 for the speed; `peak`: the peak's number. */
export interface Wrong {
  words: string;
  rule?: readonly [number, number];
  variable?: number;
  peak?: number;
}

export function braking({ body, motion, infrared }: Made): Braking {
  return {
    deceleration: Math.min(motion.acceleration, motion.braking),
    reaction: motion.forget_s,
    margin: body.length / 2 - infrared.from[0]! + NOISES * infrared.noise,
    stop: infrared.stop,
    far: infrared.far,
    most: motion.most_speed,
  };
}

/** Return everything for which the rover would refuse the set; nothing if it takes it. */
export function wrongIn(rules: RuleSet, b: Braking): Wrong[] {
  const found: Wrong[] = [];
  for (const [n, one] of [...rules.inputs, rules.output].entries()) found.push(...wrongPeaks(one, n));
  if (rules.inputs[0].name === rules.inputs[1].name) found.push({ words: "The two inputs must be different readings.", variable: 1 });
  for (const [n, { name, unit }] of rules.inputs.entries()) {
    if (!READINGS[name])
      found.push({ words: `The rover has no reading ${name}; it has ${Object.keys(READINGS).join(", ")}.`, variable: n });
    else if (READINGS[name] !== unit) found.push({ words: `The ${name} is read in ${READINGS[name]}, not in ${unit}.`, variable: n });
  }
  const measured = found.length === 0; // otherwise the speed of a rule is not known
  for (let i = 0; i < TERMS; i++)
    for (let j = 0; j < TERMS; j++) {
      const words = wrongRule(rules, i, j, b, measured);
      if (words) found.push({ words: `${ruleName(rules.inputs, i, j)} ${words}`, rule: [i, j] });
    }
  return found;
}

function wrongPeaks(one: Variable, n: number): Wrong[] {
  const found: Wrong[] = [],
    speeds = n === 2;
  for (const [k, peak] of one.peaks.entries()) {
    const before = one.peaks[k - 1],
      label = one.labels[k]!;
    if (!(Math.abs(peak) <= MOST))
      found.push({ words: `The peak of ${one.name} ${label} must be a number of at most ${MOST}.`, variable: n, peak: k });
    else if (before !== undefined && !(peak > before))
      found.push({ words: `The peaks of the ${one.name} must rise; that of ${label} does not.`, variable: n, peak: k });
    else if (speeds && (peak < SPEEDS[0] || peak > SPEEDS[1]))
      found.push({ words: `The speeds must lie in ${SPEEDS[0]} to ${SPEEDS[1]} m/s; ${label} does not.`, variable: n, peak: k });
    else if (speeds && before !== undefined && Math.round(1000 * (peak - before)) < 1000 * APART)
      found.push({ words: `The speeds must be at least ${APART} m/s apart; ${label} is not.`, variable: n, peak: k });
  }
  if (speeds && (one.name !== "speed" || one.unit !== "m/s")) found.push({ words: "The output must be the speed, in m/s.", variable: n });
  return found;
}

function wrongRule(rules: RuleSet, i: number, j: number, b: Braking, measured: boolean): string {
  const term = rules.table[i]![j]!;
  if (term < 0) return "is missing.";
  if (!measured) return "";
  const v = fastest(rules, term),
    needs = b.margin + v * b.reaction + (v * v) / (2 * b.deceleration),
    least = leastOf(rules, i, j, b);
  if (v > b.most) return `gives up to ${v.toFixed(2)} m/s; the rover goes at most ${b.most}.`;
  return needs > least
    ? `is too fast: ${v.toFixed(2)} m/s takes ${needs.toFixed(2)} m to stop, and the rule counts from ${least.toFixed(2)} m on.`
    : "";
}

/** Return the least infrared distance (m) above the reflex at which the rule counts, within the sensor's range. */
function leastOf(rules: RuleSet, i: number, j: number, b: Braking): number {
  const n = rules.inputs.findIndex(({ name }) => name === "infrared"),
    term = n === 0 ? i : j;
  return n >= 0 && term > 0 ? Math.min(Math.max(b.stop, rules.inputs[n]!.peaks[term - 1]!), b.far) : b.stop;
}

/** Return the highest speed (m/s) that can result where no rule that counts has a higher term than this one. */
function fastest({ method, output: { peaks } }: RuleSet, term: number): number {
  const own = peaks[term]!;
  return method === "sugeno" || term === 0 || term === TERMS - 1
    ? own
    : own + Math.max(0, peaks[term + 1]! - 2 * own + peaks[term - 1]!) / 2;
}
