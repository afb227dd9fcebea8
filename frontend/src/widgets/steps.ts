/** The size of a step: in the words of each button, at its default in each turn, and confirmed once where it is large. */
import { gettext } from "../kit/text.ts";

const LARGE_SHARE = 0.02; // of the range in which the robot can be: a step beyond it is far larger than usual

/** Whether a step is so large, of a value between these bounds, that it is asked about first. */
export function isLarge(step: number, { low, high }: { low: number; high: number }): boolean {
  return step > LARGE_SHARE * (high - low);
}

/** One of several sizes: `words` has its unit. */
export interface StepChoice {
  words: string;
  isLarge: boolean;
}

export class StepSize<Choice extends StepChoice> {
  private chosen: number;
  private asked = false;
  private readonly choices: readonly Choice[];
  private readonly standard: number;

  /** `standard`: the index of the default. */
  constructor(choices: readonly Choice[], standard: number) {
    [this.choices, this.standard, this.chosen] = [choices, standard, standard];
  }

  get now(): Choice {
    return this.choices[this.chosen]!;
  }

  get index(): number {
    return this.chosen;
  }

  /** Choose another size; below the first and beyond the last there is none. */
  choose(index: number): void {
    const to = Math.max(0, Math.min(this.choices.length - 1, index));
    if (to !== this.chosen) this.asked = false;
    this.chosen = to;
  }

  /** Another turn begins: somebody may not know which size was chosen before. */
  reset(): void {
    this.choose(this.standard);
    this.asked = false;
  }

  /** Return what is asked before a step of this size; empty if it may be made. A second press is the answer. */
  ask(): string {
    if (!this.now.isLarge || this.asked) return "";
    this.asked = true;
    return gettext("A step of {size} is large. Press again to make it; this is asked once.", { size: this.now.words });
  }
}
