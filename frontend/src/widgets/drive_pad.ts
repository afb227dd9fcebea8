/** Driving by hand: buttons, arrow keys and a gamepad for a held motion with shares of full speed ahead and turning. */
import { allow } from "../kit/refusal.ts";
import type { RobotPage } from "../page/robot_page.ts";
import { stick } from "./gamepad.ts";
import { Jog } from "./jog.ts";

const direction = (forward: number, turn: number): Record<string, number> => ({ forward, turn });

export class DrivePad {
  /** `gamepads`: whether it takes them; not where a stick beside it does. */
  constructor(
    private page: RobotPage,
    private pad: HTMLElement,
    gamepads = true,
    kind = "drive",
  ) {
    new Jog<Record<string, number>>(pad, {
      read: (words) => direction(...(words.split(",").map(Number) as [number, number])),
      arrows: { ArrowUp: direction(1, 0), ArrowDown: direction(-1, 0), ArrowLeft: direction(0, 1), ArrowRight: direction(0, -1) },
      stick: (one) => {
        const pushed = gamepads ? stick(one) : null;
        return pushed && direction(pushed[1], -pushed[0]);
      },
      whyNot: () => page.whyNot(kind),
      begin: (wanted) => page.issue(kind, wanted),
      ...page.keepAlive,
    });
  }

  /** Show it to whoever drives, and why it does not work now, if it does not; a motion that is held goes on. */
  draw(why: string): void {
    this.pad.hidden = !this.page.operating;
    for (const button of this.pad.querySelectorAll<HTMLElement>("[data-jog]"))
      allow(button, this.pad.classList.contains("held") ? "" : why);
  }
}
