/** A press for control or a place that is on its way: the page says so until its result is known. */
import { gettext } from "../kit/text.ts";
import type { Snapshot } from "../socket/messages.ts";

const MOST_MS = 15_000; // after this time without a step forward one decides anew
const COMES = ["ready", "handover", "offered"]; // states in which a robot comes to whoever is next
export const ASKING = gettext("Asking for control…");

/** To take is to join where nobody waits, and to accept the offer as soon as it comes. */
export type Asked = "take" | "join" | "accept";

export class Asking {
  private at = performance.now(); // of the last step forward
  private placed = false; // a place was told
  private accepted: boolean;
  readonly what: Asked;
  /** What was shown at the press: until the result is known it stays, so that nothing moves. */
  readonly shown: Snapshot | null;

  constructor(what: Asked, shown: Snapshot | null) {
    [this.what, this.shown, this.accepted] = [what, shown, what === "accept"];
  }

  get words(): string {
    return this.what === "join" ? gettext("Asking for a place in the queue…") : ASKING;
  }

  get late(): boolean {
    return performance.now() - this.at > MOST_MS;
  }

  /** Take what has come. Returns what follows: to accept the offer, or that the result is known. */
  follow({ me, robot }: Snapshot): "accept" | "over" | "" {
    const { ticket } = me;
    if (this.late || me.can.drive) return "over";
    if (!ticket) return this.placed ? "over" : "";
    this.placed = true;
    if (this.what === "join") return "over";
    if (ticket.state !== "offered") return this.accepted || ticket.ahead > 0 || !COMES.includes(robot.state) ? "over" : "";
    if (this.accepted) return "";
    [this.accepted, this.at] = [true, performance.now()];
    return "accept";
  }
}
