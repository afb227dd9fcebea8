/** How much a page asks for: live pictures, one now and then, or only states; by what the line can carry. */

export type Pace = "live" | "stills" | "states";
export const PACES: readonly Pace[] = ["live", "stills", "states"];

/** A picture that arrives older than this is late: at each pace another age, for a whole one takes its time. */
const LATE_MS: Record<Pace, number> = { live: 1500, stills: 6000, states: Infinity };
const WINDOW_MS: Record<Pace, number> = { live: 4000, stills: 20_000, states: 10_000 };
const GOOD_MS = 700; // the answer of a ping on a line that may carry more
const FIRST_HOLD_MS = 20_000, LONGEST_HOLD_MS = 320_000;

/** Judges a line by the ages of what arrives; times are of one clock, in ms. */
export class LineJudge {
  pace: Pace;
  private since: number; // when this pace began
  private hold = FIRST_HOLD_MS; // before more is tried; doubled when that failed
  private least = Infinity; // the least age in this window
  private windowAt: number;

  constructor(now: number, pace: Pace = "live") {
    this.pace = pace;
    this.since = this.windowAt = now;
  }

  /** A picture has arrived, so old. */
  arrived(ageMs: number): void {
    this.least = Math.min(this.least, ageMs);
  }

  /**
   * Judge again; returns whether the pace has changed. `waiting`: pictures are expected, for the robot sends some;
   * `latency`: of the last ping, null while its answer is missing for long.
   */
  judge(now: number, waiting: boolean, latency: number | null): boolean {
    if (now - this.windowAt < WINDOW_MS[this.pace]) return false;
    const late = waiting && this.least > LATE_MS[this.pace] && (this.least < Infinity || latency === null || latency > GOOD_MS);
    this.windowAt = now;
    this.least = Infinity;
    const at = PACES.indexOf(this.pace);
    if (late && at < PACES.length - 1) {
      if (now - this.since < this.hold) this.hold = Math.min(LONGEST_HOLD_MS, this.hold * 2);
      return this.go(PACES[at + 1]!, now);
    }
    if (now - this.since > LONGEST_HOLD_MS) this.hold = FIRST_HOLD_MS;
    if (!late && at > 0 && latency !== null && latency < GOOD_MS && now - this.since >= this.hold) return this.go(PACES[at - 1]!, now);
    return false;
  }

  private go(pace: Pace, now: number): boolean {
    this.pace = pace;
    this.since = now;
    return true;
  }
}
