/** Loads what judges poses in the page, which is large, beside all else. */
import type { ArmFacts, BoxFacts } from "../motion/facts.ts";
import type { PoseJudge } from "./judge.ts";

/** Return a judge of poses of that arm; null if it did not come, or knows no such arm: then the server judges, on Send. */
export async function loadJudge(facts: ArmFacts, added: readonly BoxFacts[]): Promise<PoseJudge | null> {
  try {
    const { PoseJudge } = await import("./judge.ts");
    return new PoseJudge(facts, added);
  } catch (error) {
    console.warn(error);
    return null;
  }
}
