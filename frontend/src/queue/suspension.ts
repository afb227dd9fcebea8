/** The part of a robot's page that says that a stop has suspended its jobs; staff resume them there. */
import { say } from "../kit/dom.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { gettext } from "../kit/text.ts";
import type { Snapshot } from "../socket/messages.ts";
import { UNSENT } from "./person_socket.ts";

const FIRST = { stopped: gettext("Release the stop first."), released: gettext("Look at the robot first.") };

export class Suspension {
  private box = document.getElementById("suspended"); // a recording's page has none
  private button = this.box?.querySelector("button");
  private first = document.getElementById("resume-first");

  constructor(notice: (words: string, level: string) => void) {
    this.box?.addEventListener("submit", (event) => {
      const why = !navigator.onLine ? UNSENT : this.button ? refusal(this.button) : ""; // offline the browser would leave the page
      if (!why) return;
      event.preventDefault();
      notice(why, "warning");
    });
  }

  draw(s: Snapshot, lineUp: boolean): void {
    if (this.box) this.box.hidden = !s.suspended;
    if (this.button) allow(this.button, !lineUp ? UNSENT : s.stopped ? FIRST.stopped : "");
    if (this.first) say(this.first, s.stopped ? FIRST.stopped : FIRST.released);
  }
}
