/** The arm follows the ghost while a control is held: one held command, whose keep-alives carry where the ghost is. */
import type { KeepAlive } from "../socket/held_motion.ts";
import { argumentsOf, isLost, Steering } from "./steering.ts";
import { type Move, STILL } from "./source.ts";
import { gettext } from "../kit/text.ts";

const KEEP_MS = 60, // at least between two keep-alives; the loop comes every 40 ms
  AGAIN_MS = 480; // where the ghost rests it is told again so seldom, because the line may be thin

export interface FollowUse extends KeepAlive {
  /** Why it may not begin; empty if it may. */
  whyNot(): string;
  /** Issue the command. Returns its number; 0 if it was not sent. */
  begin(args: Record<string, number>): number;
  /** How far the ghost is from where it was taken. */
  way(): Move;
  /** It is over. `why`: what to say. */
  over(why: string): void;
}

export class Follow {
  private seq = 0;
  private steering = new Steering();
  private closed: number | undefined; // what the gripper was told meanwhile
  private keptAt = 0;
  private told = { words: "", at: 0 }; // the newest values that were sent
  private readonly use: FollowUse;
  private readonly now: () => number;

  constructor(use: FollowUse, now: () => number) {
    [this.use, this.now] = [use, now];
  }

  get on(): boolean {
    return this.seq !== 0;
  }

  /** Begin, or show why that does not work. Returns whether the arm follows. */
  begin(): boolean {
    if (this.seq) return true;
    const why = this.use.whyNot();
    if (why) {
      this.use.refused(why, () => this.use.whyNot());
      return false;
    }
    this.steering = new Steering(); // nothing is left of the time before
    this.closed = undefined;
    this.keptAt = this.now();
    this.told = { words: "", at: 0 };
    this.seq = this.use.begin(argumentsOf(STILL));
    return this.on;
  }

  /** A hand has moved the ghost. Returns whether it is still the same hand; one that has jumped is lost. */
  moved(by: Move): boolean {
    if (!this.seq || !isLost(by)) return true;
    this.end(gettext("The hand jumped, so the arm was held. Take the ghost again."));
    return false;
  }

  grip(closed: number): void {
    if (this.seq) this.closed = closed;
  }

  /** Tell that the control is held; called often. */
  tick(): void {
    if (!this.seq) return;
    if (this.use.ended(this.seq)) return this.end(gettext("The arm no longer follows. Let go, look, and hold again."));
    const now = this.now(),
      passed = now - this.keptAt;
    if (passed < KEEP_MS) return;
    this.keptAt = now;
    const args = this.steering.next(this.use.way(), passed / 1000);
    if (this.closed !== undefined) args["closed"] = this.closed;
    const words = JSON.stringify(args),
      isNews = words !== this.told.words || now - this.told.at >= AGAIN_MS;
    if (isNews) this.told = { words, at: now };
    this.use.keep(this.seq, isNews ? args : undefined);
  }

  /** The control was released, or is lost. */
  end(why = gettext("Let go: the arm holds.")): void {
    if (!this.seq) return;
    this.use.release(this.seq);
    this.seq = 0;
    this.use.over(why);
  }
}
