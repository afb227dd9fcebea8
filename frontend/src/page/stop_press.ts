/** A press of Stop, until it is known to have arrived at the portal, and the texts meanwhile. */
import type { Snapshot } from "../socket/messages.ts";
import type { RobotSocket } from "../socket/robot_socket.ts";
import { gettext } from "../kit/text.ts";

const ANSWER_MS = 1500;
/** A Stop is sent at most so long after its press, and only into the turn that it was meant for. */
const LATE_MS = 60_000;
export const UNSENT = gettext(
  "Stop could not be sent; it is sent when the connection is back. What you hold down ends within half a second, " +
    "a move that has begun goes on within its limits, and after 20 s the robot is held.",
);

export class StopPress {
  private at = 0;
  private grant: number | null = null;
  private socket = 0;
  private again = 0; // how often it was sent again over another socket before an answer had come
  private snapshot: Snapshot | null = null;

  private live: Pick<RobotSocket, "send" | "lost" | "opened">;
  private notice: (words: string, level: string) => void;

  constructor(live: Pick<RobotSocket, "send" | "lost" | "opened">, notice: (words: string, level: string) => void) {
    this.live = live;
    this.notice = notice;
  }

  /** The banner's text while a press has not arrived at the portal. */
  get pending(): string {
    return this.at && (this.live.lost || performance.now() - this.at > ANSWER_MS) ? UNSENT : "";
  }

  press(): void {
    if (!this.at) this.grant = this.snapshot?.turn?.grant ?? null;
    this.at = performance.now();
    this.again = 0;
    this.socket = this.live.send({ t: "stop" }) ? this.live.opened : 0;
  }

  /**
   * Take the portal's answer. Returns whether its text is left out: a late arrival is shown instead, and further answers
   * to the same press say nothing new.
   */
  answer(ok: boolean): boolean {
    if (!this.at && ok && this.again > 0) {
      this.again -= 1;
      return true;
    }
    const late = ok && this.at > 0 && performance.now() - this.at > ANSWER_MS;
    if (late)
      this.notice(
        gettext("The connection is back: the Stop that you pressed {seconds} s ago has been sent now.", { seconds: this.ago() }),
        "warning",
      );
    this.at = 0;
    return late;
  }

  /** Take a snapshot. After a reconnection a press that still applies is sent again; a Stop can only hold the robot. */
  update(s: Snapshot): void {
    this.snapshot = s;
    if (!this.at || this.socket === this.live.opened) return;
    const meant = s.me.can.stop && (s.turn?.grant ?? null) === this.grant && performance.now() - this.at < LATE_MS;
    if (meant) {
      if (this.socket) this.again += 1;
      this.socket = this.live.send({ t: "stop" }) ? this.live.opened : 0;
    } else {
      const seconds = this.ago();
      this.notice(
        gettext("The connection is back. The Stop that you pressed {seconds} s ago was not sent: the turn that it was meant for is over.", {
          seconds,
        }),
        "warning",
      );
      this.at = 0;
    }
  }

  private ago(): number {
    return Math.round((performance.now() - this.at) / 1000);
  }
}
