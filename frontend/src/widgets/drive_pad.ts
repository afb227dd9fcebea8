/** Driving by hand: buttons, arrow keys and a gamepad for a held motion with shares of full speed ahead and turning. */
import type { RobotPage } from "../page/robot_page.ts";
import { stick } from "./gamepad.ts";
import { Jog } from "./jog.ts";

const direction = (forward: number, turn: number): Record<string, number> => ({ forward, turn });

export class DrivePad {
  private jog: Jog<Record<string, number>>;

  /** `gamepads`: whether the pad reads gamepads; a stick beside it may do that instead. */
  constructor(
    private page: RobotPage,
    private pad: HTMLElement,
    gamepads = true,
    kind = "drive",
  ) {
    this.jog = new Jog(pad, {
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

  /** Show the pad to the person who drives, enabled or disabled with a reason; a motion that is held goes on. */
  draw(why: string): void {
    this.pad.hidden = !this.page.operating;
    this.jog.enable(why);
  }
}
