/** A gamepad as a source: its sticks move, with its left shoulder button they turn; its right trigger holds. */
import { type Pad, Pads, twist } from "../widgets/gamepad.ts";
import { type Grip, type Move, type Reading, type Source, STILL } from "./source.ts";
import { pushed } from "./speeds.ts";

/** Buttons of the layout that browsers call standard. */
const CLOSE = 0,
  OPEN = 1,
  TURNS = 4,
  HOLD = 7;

/** Return what a gamepad asks for in that time; null if nothing is pushed or pressed. */
export function padReading(pad: Pad, elapsed_s: number): Reading | null {
  const down = (i: number): boolean => pad.buttons[i]?.pressed === true;
  const push = twist(pad),
    clutch = down(HOLD),
    grip: Grip = down(CLOSE) ? "close" : down(OPEN) ? "open" : "";
  if (!push && !clutch && !grip) return null;
  const { x = 0, y = 0, z = 0, yaw = 0 } = push ?? {};
  const turns: Move = [0, 0, 0, -y, x, yaw]; // to the left it leans to the left, up it leans away
  return { by: push ? pushed(down(TURNS) ? turns : [x, y, z, 0, 0, yaw], elapsed_s) : STILL, clutch, grip };
}

export class GamepadSource implements Source {
  readonly name = "gamepad";
  readonly isRate = true;
  private pads = new Pads();
  private readonly control: HTMLElement;
  private readonly here: () => boolean;

  /** `here`: whether it may move the ghost now; else all of it has to be released before it counts. */
  constructor(control: HTMLElement, here: () => boolean) {
    [this.control, this.here] = [control, here];
  }

  read(elapsed_s: number): Reading | null {
    if (this.here()) return this.pads.wanted(this.control, (pad) => padReading(pad, elapsed_s));
    this.forget();
    return null;
  }

  forget(): void {
    this.pads.forget();
  }
}
