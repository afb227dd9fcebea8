/** The held motion of this page, from its press to its release. */
import { gettext } from "../kit/text.ts";

/** What the control of a held motion needs from the page. */
export interface KeepAlive {
  /** Send a keep-alive. `args`: newer values of a motion that is steered. */
  keep(seq: number, args?: Record<string, number>): void;
  release(seq: number): void;
  /** Return whether that command has ended. */
  ended(seq: number): boolean;
  /** Show why a motion may not start; `again` returns the reason later, empty once there is none. */
  refused(why: string, again?: () => string): void;
}

/** What `HeldMotion` needs from the page. */
interface HeldLine extends Pick<KeepAlive, "ended"> {
  send(message: object): unknown;
  refused(why: () => string): void;
  /** Whether what is sent now reaches the portal too late for a held motion. */
  late(): boolean;
}

/** The robot rests if it hears nothing for so long (workers/guard/deadman.py), ms. */
export const SILENT_MS = 250;
export const TOO_SLOW = gettext(
  "The line is too slow for a motion that is held: the robot hears too late that you hold it, and rests by itself. " +
    "Send single moves instead.",
);

export class HeldMotion implements KeepAlive {
  private seq = 0;
  private last = { seq: 0, kind: "" };
  private readonly line: HeldLine;

  constructor(line: HeldLine) {
    this.line = line;
  }

  /** Whether a motion is held: keep-alives count only over the socket that carried the command, so that socket has to stay. */
  get held(): boolean {
    return this.seq !== 0 && !this.ended(this.seq);
  }

  /** Note that the command of a held motion has been sent. */
  hold(seq: number, kind: string): void {
    this.seq = seq;
    this.last = { seq, kind };
  }

  /** Return the kind of that held motion, which is the last one; empty for another. */
  kindOf(seq: number): string {
    return this.last.seq === seq ? this.last.kind : "";
  }

  // members of the object itself, because consoles spread it
  readonly keep = (seq: number, args?: Record<string, number>): void => {
    this.line.send({ t: "keep", seq, ...(args ? { args } : {}) });
    if (this.line.late()) this.line.refused(() => TOO_SLOW);
  };
  readonly release = (seq: number): void => {
    if (seq === this.seq) this.seq = 0;
    this.line.send({ t: "released", seq });
  };
  readonly ended = (seq: number): boolean => this.line.ended(seq);
  readonly refused = (why: string, again = (): string => why): void => this.line.refused(again);
}
