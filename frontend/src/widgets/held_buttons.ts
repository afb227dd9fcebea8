/** A held motion: a pair of buttons for each of its values, which are shares of full speed. */
import { allow } from "../kit/refusal.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { CommandSpec } from "../socket/messages.ts";
import { Jog, named } from "./jog.ts";

export class HeldButtons {
  readonly element = document.createElement("div");
  private buttons: HTMLElement[] = [];

  constructor(page: RobotPage, spec: CommandSpec) {
    this.element.className = "plain-command";
    this.element.setAttribute("role", "group");
    this.element.setAttribute("aria-label", `${spec.label}: hold to move`);
    for (const argument of spec.arguments)
      for (const [way, sign] of [
        [-1, "−"],
        [1, "+"],
      ] as const) {
        const button = document.createElement("button");
        Object.assign(button, { type: "button", className: "button", textContent: `${argument.name} ${sign}` });
        button.dataset["jog"] = `${argument.name},${way}`;
        button.setAttribute("aria-describedby", "why");
        this.buttons.push(button);
      }
    this.element.append(...this.buttons);
    new Jog<Record<string, number>>(this.element, {
      read: named,
      arrows: {},
      stick: () => null,
      whyNot: () => page.whyNot(spec.kind),
      begin: (direction) => page.issue(spec.kind, direction),
      ...page.keepAlive,
    });
  }

  /** Enable the buttons, or disable them with a reason; a motion that is held goes on. */
  enable(why: string): void {
    for (const button of this.buttons) allow(button, this.element.classList.contains("held") ? "" : why);
  }
}
