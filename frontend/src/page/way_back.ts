/** Where the robot was before its last move: noted as the move is given, forgotten with the turn. */
import { gettext } from "../kit/text.ts";
import type { CommandInfo } from "../socket/messages.ts";
import { FINAL } from "../socket/stages.ts";

type Told = Pick<CommandInfo, "seq" | "grant" | "kind" | "state">;
const EARLY = new Set(["sending", "queued", "accepted"]); // nothing has moved
const NEVER = new Set(["rejected", "expired"]); // and nothing will

export class WayBack {
  private grant = 0;
  private starts = new Map<number, readonly number[]>(); // of moves that have not ended, by their numbers
  private from: readonly number[] | null = null;
  private moved = "";
  private readonly kinds: ReadonlySet<string>;
  private readonly here: () => readonly number[];

  /** `kinds`: the moves to a position; `here`: the joints, or what else says where it is, empty while it is not known. */
  constructor(kinds: readonly string[], here: () => readonly number[]) {
    this.kinds = new Set(kinds);
    this.here = here;
  }

  /** Where the robot was before the last move of this turn that has ended; null if there was none. */
  get joints(): readonly number[] | null {
    return this.from;
  }

  /** The kind of that move. */
  get kind(): string {
    return this.moved;
  }

  /** Another turn, or none: nothing is remembered. */
  turn(grant: number): void {
    if (grant === this.grant) return;
    this.grant = grant;
    this.starts.clear();
    this.from = null;
  }

  /** Take a stage of a command. A move that replaces another one began where that one did. */
  take({ seq, grant, kind, state }: Told): void {
    if (grant !== this.grant) return;
    const start = this.starts.get(seq);
    if (!start && this.kinds.has(kind) && EARLY.has(state)) {
      const joints = [...this.starts.values()].at(-1) ?? this.here();
      if (joints.length) this.starts.set(seq, joints);
    } else if (start && FINAL.has(state)) {
      this.starts.delete(seq);
      if (!NEVER.has(state)) [this.from, this.moved] = [start, kind];
    }
  }

  /** Return why there is no way back; empty if there is one. `near`: the largest difference of a joint that is none. */
  whyNot(near: number): string {
    const here = this.here(),
      { from } = this;
    if (!from) return gettext("There is nothing to go back to: no move to a position has ended in this turn.");
    if (from.every((q, i) => Math.abs(q - (here[i] ?? Infinity)) <= near))
      return gettext("The robot is where it was before its last move.");
    return "";
  }
}
