/** The commands of this page under the present grant: their numbers, the list of them, and the one that is held. */
import { byId } from "../kit/dom.ts";
import type { Connection } from "../socket/connection.ts";
import { HeldMotion } from "../socket/held_motion.ts";
import type { Answer, CommandInfo, Snapshot } from "../socket/messages.ts";
import { laterStage } from "../socket/stages.ts";
import { CommandList } from "./command_list.ts";
import { configKinds, facts } from "./facts.ts";

export class Commands {
  readonly list = new CommandList(byId("ladder"), byId("say"));
  readonly heldMotion: HeldMotion;
  /** The number of the newest command of this grant; 0 if there is none. */
  seq = 0;
  grant = 0;
  private planned = 0;
  private snapshotOver = 0; // the socket over which the last snapshot came

  /** `refuse` shows why a held motion may not start. */
  constructor(
    private connection: () => Connection,
    refuse: (why: () => string) => void,
  ) {
    this.heldMotion = new HeldMotion({
      send: (m) => connection().send(m),
      ended: (seq) => this.list.ended(this.grant, seq),
      refused: refuse,
    });
  }

  /** Whether a motion of this grant runs, waits or is held. */
  get busy(): boolean {
    return this.heldMotion.held || (this.grant !== 0 && this.list.busy(this.grant, configKinds));
  }

  /** Put the next command into the list and send it; `seen`: when the picture on the page was taken, 0 without one. */
  issue(kind: string, args: object, seen: number): number {
    const connection = this.connection();
    this.seq += 1;
    this.list.update({
      id: 0,
      seq: this.seq,
      grant: this.grant,
      kind,
      state: "sending",
      reason: "",
      at_ms: connection.now(),
      over: connection.opened,
      result: {},
    });
    performance.mark(`command-${this.seq}`);
    connection.send({ t: "command", kind, args, seq: this.seq, ...(seen ? { seen } : {}) });
    if (facts.commands.some((c) => c.kind === kind && c.held)) this.heldMotion.hold(this.seq);
    return this.seq;
  }

  /** Ask where a command would lead from these joints. Returns the number that its answer has. */
  plan(kind: string, args: object, joints: readonly number[]): number {
    this.connection().send({ t: "plan", n: ++this.planned, kind, args, from: joints });
    return this.planned;
  }

  /** Count on from where a snapshot's turn is. Returns whether it has another grant. */
  follow({ turn }: Snapshot): boolean {
    this.snapshotOver = this.connection().opened;
    if (!turn) return false;
    const other = turn.grant !== this.grant;
    this.seq = other ? turn.next_seq - 1 : Math.max(this.seq, turn.next_seq - 1);
    this.grant = turn.grant;
    return other;
  }

  /** Show what a snapshot contains; of a recording it is another moment. */
  show(s: Snapshot): void {
    if (s.replay) this.list.clear();
    this.list.reset(s.commands);
  }

  /** Show that the server refused a command. */
  refused(answer: Answer): void {
    this.list.refuse(this.grant, answer.seq ?? 0, answer.text, this.connection().now());
  }

  /** Called again and again: end what was sent over a socket that is gone. */
  draw(): void {
    this.list.lost(this.snapshotOver, this.connection().now());
  }
}

/** A snapshot's commands, which may have been read earlier than what is known of them. */
export function latestStages(read: readonly CommandInfo[], known: readonly CommandInfo[] = []): CommandInfo[] {
  const before = new Map(known.map((c) => [c.id, c]));
  return read.map((c) => laterStage(before.get(c.id), c));
}
