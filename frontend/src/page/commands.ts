/** The commands of this page under the present grant: their numbers, their list, and the held motion. */
import { byId } from "../kit/dom.ts";
import type { Connection } from "../socket/connection.ts";
import { HeldMotion, SILENT_MS } from "../socket/held_motion.ts";
import type { Answer, CommandInfo, Snapshot } from "../socket/messages.ts";
import { laterStage } from "../socket/stages.ts";
import { CommandList } from "./command_list.ts";
import { configKinds, facts } from "./facts.ts";

/** The parts of the page that `Commands` needs. `refuse` shows why a held motion may not start. */
interface CommandsUse {
  readonly live: Connection;
  refuse(why: () => string): void;
}

export class Commands {
  readonly list = new CommandList(byId("ladder"), byId("say"), byId("last-command"));
  readonly heldMotion: HeldMotion;
  /** The number of the newest command of this grant; 0 if there is none. */
  seq = 0;
  grant = 0;
  private planned = 0;
  private snapshotOver = 0; // the socket over which the last snapshot came

  constructor(private use: CommandsUse) {
    this.heldMotion = new HeldMotion({
      send: (m) => use.live.send(m),
      ended: (seq) => this.list.ended(this.grant, seq),
      refused: (why) => use.refuse(why),
      late: () => (use.live.lateMs ?? 0) > SILENT_MS || use.live.overdue,
    });
  }

  /** Whether a motion of this grant runs, waits or is held. */
  get busy(): boolean {
    return this.heldMotion.held || (this.grant !== 0 && this.list.motion(this.grant, configKinds) !== undefined);
  }

  /** Put the next command into the list and send it. Returns its number; `seen`: when the picture on the page was taken (ms). */
  issue(kind: string, args: object, seen: number): number {
    const { live } = this.use;
    const seq = ++this.seq,
      sent = { at_ms: live.now(), over: live.opened };
    this.list.update({ id: 0, seq, grant: this.grant, kind, state: "sending", reason: "", result: {}, ...sent });
    performance.mark(`command-${seq}`);
    live.send({ t: "command", kind, args, seq, ...(seen ? { seen } : {}) });
    if (facts.commands.some((c) => c.kind === kind && c.held)) this.heldMotion.hold(seq, kind);
    return seq;
  }

  /** Ask where a command would lead from these joints (rad, m). Returns the number of the answer. */
  plan(kind: string, args: object, joints: readonly number[]): number {
    this.use.live.send({ t: "plan", n: ++this.planned, kind, args, from: joints });
    return this.planned;
  }

  /** Continue with the numbers of a snapshot's turn. Returns whether its grant is another one. */
  follow({ turn }: Snapshot): boolean {
    this.snapshotOver = this.use.live.opened;
    if (!turn) return false;
    const other = turn.grant !== this.grant;
    this.seq = other ? turn.next_seq - 1 : Math.max(this.seq, turn.next_seq - 1);
    this.grant = turn.grant;
    return other;
  }

  /** Show the commands of a snapshot; in a recording it may be another moment, so the list begins again. */
  show(s: Snapshot): void {
    if (s.replay) this.list.clear();
    this.list.reset(s.commands);
  }

  /** Show that the server refused a command. */
  refused(answer: Answer): void {
    this.list.refuse(this.grant, answer.seq ?? 0, answer.text, this.use.live.now());
  }

  /** End what was sent over a socket that is gone; called again and again. */
  draw(): void {
    this.list.lost(this.snapshotOver, this.use.live.now());
  }
}

/** Return the commands of a snapshot, with the stages already known where the snapshot was read before those. */
export function latestStages(read: readonly CommandInfo[], known: readonly CommandInfo[] = []): CommandInfo[] {
  const before = new Map(known.map((c) => [c.id, c]));
  return read.map((c) => laterStage(before.get(c.id), c));
}
