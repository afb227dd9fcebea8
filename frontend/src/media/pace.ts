/** How much a page asks for: live pictures, coarse ones, one now and then, or only states; by what the line can carry. */

export type Pace = "live" | "coarse" | "stills" | "states";
export const PACES: readonly Pace[] = ["live", "coarse", "stills", "states"];

/** A picture that is older than this when it arrives is late; a whole picture takes longer than a coarse one. */
const LATE_MS: Record<Pace, number> = { live: 1500, coarse: 1500, stills: 6000, states: Infinity };
const WINDOW_MS: Record<Pace, number> = { live: 4000, coarse: 4000, stills: 20_000, states: 10_000 };
const QUICK_MS = 700,
  SLOW_MS = 1500;
const SHORT_WINDOWS = 2; // after so many windows in a row with too little the pace goes down
const FIRST_HOLD_MS = 20_000,
  LONGEST_HOLD_MS = 320_000;

/** Return whether the line may carry more, by the `latency` of an answer (ms; null: it is overdue) and the `best` one so far. */
export function isQuick(latency: number | null, best: number): boolean {
  return latency !== null && latency < Math.min(SLOW_MS, Math.max(QUICK_MS, 2 * best));
}

/** Judges a line by how much and how old is what arrives, and by the answers to pings; times are of one clock, in ms. */
export class LineJudge {
  pace: Pace;
  private top: Pace;
  private since: number; // when this pace began
  private tried = false; // this pace was tried after a lower one
  private hold = FIRST_HOLD_MS; // before more is tried; doubled after a failure
  private least = Infinity; // the least age in this window
  private newest = 0; // the age of the newest picture when it arrived
  private windowAt: number;
  private shortFor = 0; // windows

  /** `top`: the most that is ever asked for. */
  constructor(now: number, top: Pace = "live") {
    this.pace = this.top = top;
    this.since = this.windowAt = now;
  }

  /** Note that a picture of that age has arrived. */
  arrived(ageMs: number): void {
    this.least = Math.min(this.least, ageMs);
    this.newest = ageMs;
  }

  /** Whether nothing has arrived in time in this window; the answer to a ping shows why. */
  get doubts(): boolean {
    return this.least > LATE_MS[this.pace];
  }

  /**
   * Judge again. Returns whether the pace has changed. `waiting`: the robot sends pictures; `fast`: see `isQuick`;
   * `short`: fewer bytes arrive than this pace needs.
   */
  judge(now: number, waiting: boolean, fast: boolean, short = false): boolean {
    if (now - this.windowAt >= WINDOW_MS[this.pace]) {
      this.shortFor = waiting && short ? this.shortFor + 1 : 0;
      const late = (waiting && !fast && this.doubts) || this.shortFor >= SHORT_WINDOWS;
      this.windowAt = now;
      this.least = Infinity;
      if (late) return this.down(now);
    }
    if (this.pace === "live" && now - this.since > LONGEST_HOLD_MS) this.hold = FIRST_HOLD_MS;
    const above = PACES[PACES.indexOf(this.pace) - 1];
    if (this.newest > LATE_MS[this.pace]) return false; // answers overtake pictures, so they say little of what the line carries
    if (!fast || short || above === undefined || this.pace === this.top || now - this.since < this.hold) return false;
    this.tried = true;
    return this.go(above, now);
  }

  /** Go down to the next pace. Returns whether there is one. */
  down(now: number): boolean {
    const below = PACES[PACES.indexOf(this.pace) + 1];
    if (below === undefined) return false;
    if (this.tried && now - this.since < this.hold) this.hold = Math.min(LONGEST_HOLD_MS, this.hold * 2);
    this.tried = false;
    return this.go(below, now);
  }

  private go(pace: Pace, now: number): boolean {
    this.pace = pace;
    this.since = this.windowAt = now;
    this.least = Infinity;
    this.newest = this.shortFor = 0;
    return true;
  }
}
