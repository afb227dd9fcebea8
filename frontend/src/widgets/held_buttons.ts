/** A held motion: a pair of buttons for each of its values, which are shares of full speed. */
import { make, set } from "../kit/dom.ts";
import { gettext, translate } from "../kit/text.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { CommandSpec } from "../socket/messages.ts";
import { Jog, named } from "./jog.ts";

export class HeldButtons {
  readonly element = make("div", { class: "plain-command", role: "group" });
  private jog: Jog<Record<string, number>>;

  constructor(page: RobotPage, spec: CommandSpec) {
    set(this.element, { "aria-label": gettext("{command}: hold to move", { command: spec.label }) });
    for (const { name } of spec.arguments)
      for (const sign of ["−", "+"]) {
        const jog = `${name},${sign === "+" ? 1 : -1}`;
        const attributes = { type: "button", class: "button", "data-jog": jog, "aria-describedby": "why" };
        this.element.append(make("button", attributes, `${translate(name)} ${sign}`));
      }
    this.jog = new Jog(this.element, {
      read: named,
      whyNot: () => page.whyNot(spec.kind),
      begin: (direction) => page.issue(spec.kind, direction),
      ...page.keepAlive,
    });
  }

  /** Enable the buttons, or disable them with a reason; a motion that is held goes on. */
  enable(why: string): void {
    this.jog.enable(why);
  }
}
