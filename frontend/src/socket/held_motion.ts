/** The held motion of this page, from its press to its release. */

/** What the control of a held motion needs from the page. */
export interface KeepAlive {
  /** `args`: newer values of a motion that is steered. */
  keep(seq: number, args?: Record<string, number>): void;
  release(seq: number): void;
  /** Whether that command has ended. */
  ended(seq: number): boolean;
  /** A motion may not start; `again` tells whether that is still so. */
  refused(why: string, again?: () => string): void;
}

/** What it needs from the page. */
export interface HeldLine {
  send(message: object): unknown;
  /** Whether that command has ended. */
  ended(seq: number): boolean;
  refused(why: () => string): void;
}

export class HeldMotion implements KeepAlive {
  private seq = 0;
  private readonly line: HeldLine;

  constructor(line: HeldLine) {
    this.line = line;
  }

  /** Whether controls are held: keep-alives count only over the socket that carried their command, so it has to stay. */
  get held(): boolean {
    return this.seq !== 0 && !this.ended(this.seq);
  }

  /** Its command is sent. */
  hold(seq: number): void {
    this.seq = seq;
  }

  // members of the object itself, because consoles spread it
  readonly keep = (seq: number, args?: Record<string, number>): void => void this.line.send({ t: "keep", seq, ...(args ? { args } : {}) });
  readonly release = (seq: number): void => {
    if (seq === this.seq) this.seq = 0;
    this.line.send({ t: "released", seq });
  };
  readonly ended = (seq: number): boolean => this.line.ended(seq);
  readonly refused = (why: string, again = (): string => why): void => this.line.refused(again);
}
