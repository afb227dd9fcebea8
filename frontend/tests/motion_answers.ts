/** What the browser's planner makes of the cases that Python and it both plan (tests/arm_cases.py). */
import { readFileSync } from "node:fs";
import { Budget, Refused } from "../src/motion/budget.ts";
import type { ArmFacts } from "../src/motion/facts.ts";
import { Planner } from "../src/motion/planner.ts";

export interface Case {
  start: number[];
  of: number[]; // the pose to go to is that of the tool with these joints,
  shift?: number[]; // moved by so much (m);
  joints?: number[]; // or these joints are the target
  velocity?: number[];
  scale: number;
}
export interface Answers {
  tool: number[];
  distances: number[];
  reached?: number[];
  seconds?: number;
  third?: number[]; // the joints after a third of the time
  text?: string;
  code?: string;
}

export function poseIn(planner: Planner, { of, shift }: Case): Float64Array {
  const pose = planner.chain.forward(of);
  for (const [k, by] of (shift ?? []).entries()) pose[4 * k + 3]! += by;
  return pose;
}

function outcome(planner: Planner, one: Case): Partial<Answers> {
  const target = one.joints ? { joints: one.joints } : { pose: poseIn(planner, one) },
    present = { joints: one.start, velocity: one.velocity ?? new Array<number>(6).fill(0) };
  const plan = planner.plan(target, present, one.scale);
  return plan.ok ? { seconds: plan.seconds, third: [...plan.path.sample(plan.seconds / 3)] } : { text: plan.text, code: plan.code };
}

/** `plans`: whether the motion is planned, too, beside the inverse solution. */
export function answers(planner: Planner, one: Case, plans = true): Answers {
  const told: Answers = { tool: [...planner.chain.forward(one.start)], distances: [...planner.zones.distances(one.start)] };
  try {
    if (!one.joints) told.reached = planner.reach(poseIn(planner, one), one.start, new Budget());
  } catch (error) {
    if (!(error instanceof Refused)) throw error;
  }
  return plans ? { ...told, ...outcome(planner, one) } : told;
}

/** Return, for arms that begin outside all boxes, the median and the 99th percentile of the processor's time for one call of each (microseconds), after a first round. */
function times(planner: Planner, every: Case[]): Record<string, number[]> {
  const cases = every.filter(({ start }) => planner.zones.distances(start).every((distance) => distance > 0));
  const poses = cases.map((one) => poseIn(planner, one)),
    found: Record<string, number[]> = {};
  const run = (name: string, call: (one: Case, n: number) => unknown): void => {
    for (const [n, one] of cases.slice(0, 300).entries()) call(one, n);
    const measured = cases.map((one, n) => {
      const began = process.cpuUsage();
      call(one, n);
      const { user, system } = process.cpuUsage(began);
      return user + system;
    });
    measured.sort((a, b) => a - b);
    found[name] = [0.5, 0.99].map((share) => measured[Math.floor(share * measured.length)]!);
  };
  run("plan", (one) => outcome(planner, one));
  run("nearest", (one, n) => {
    try {
      return planner.reach(poses[n]!, one.start);
    } catch {
      return null; // out of reach
    }
  });
  return found;
}

interface Asked {
  facts: ArmFacts;
  cases: Case[];
  plans: boolean;
  times: boolean;
}

if (process.argv[1] === import.meta.filename) {
  const { facts, cases, plans, times: measured } = JSON.parse(readFileSync(0, "utf-8")) as Asked;
  const planner = new Planner(facts);
  const found = { answers: cases.map((one) => answers(planner, one, plans)), us: measured ? times(planner, cases) : {} };
  process.stdout.write(JSON.stringify(found));
}
