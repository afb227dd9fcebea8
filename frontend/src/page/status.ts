/** The words about a robot on its page: its state, who drives, who watches, and whether a stop holds it. */
import { byId, say } from "../kit/dom.ts";
import { shownName } from "../kit/names.ts";
import { gettext, ngettext, translate } from "../kit/text.ts";
import { watcherWords } from "../queue/waits.ts";
import type { Snapshot } from "../socket/messages.ts";
import { unconfirmedStop } from "./banner.ts";
import { blocked, type Facts } from "./controls.ts";
import { pointedRefusal } from "./stage.ts";

export class Status {
  /** How many people watch, without the driver; null while that is not known. */
  watchers: number | null = null;
  private page = byId("robot");

  /** `advice`: the line in the bar if nothing prevents commands, neither in general nor the control that is pointed at. */
  draw(s: Snapshot, f: Facts, advice: (f: Facts) => string): void {
    this.page.dataset["state"] = s.robot.state;
    this.page.classList.toggle("operating", s.me.can.drive);
    say(byId("state"), translate(s.robot.label));
    say(byId("why-state"), translate(s.robot.why));
    this.people(s);
    byId("controls").hidden = !s.me.can.drive && !s.me.can.stop;
    byId("stop-place").hidden = !s.me.can.stop;
    byId("release").hidden = !(s.stopped || f.state?.stopped) || !s.me.can.stop;
    say(byId("stop-said"), unconfirmedStop(s.stop, f.now) ? gettext("Stop is pressed") : gettext("The robot is stopped"));
    const why = byId("why");
    say(why, blocked(f) || pointedRefusal() || advice(f));
    why.title = why.textContent;
  }

  private people(s: Snapshot): void {
    const driven = s.operator ? gettext("{name} drives", { name: shownName(s.operator) }) : s.robot.turns ? gettext("Nobody drives") : "";
    const watch = this.watchers === null || s.replay ? "" : `, ${watcherWords(this.watchers, s.me.can.drive)}`;
    const nobody = driven ? gettext("nobody waits") : gettext("Nobody waits");
    const queue = s.queue === 0 ? nobody : ngettext("{count} waiting", "{count} waiting", s.queue);
    const operator = byId("operator"),
      who = operator.parentElement as HTMLElement;
    say(operator, driven);
    say(byId("watchers"), watch);
    say(byId("queue"), queue);
    const cheers = byId("cheers").textContent;
    who.title = `${driven ? `${driven}, ` : ""}${queue}${watch}${cheers}`; // a narrow window cuts it
  }
}
