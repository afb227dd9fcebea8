/** The handles of the ghost in the view as a source: they are held while a pointer drags them. */
import type { Rigid } from "../motion/rigid.ts";
import { Clutch } from "./clutch.ts";
import { HOME, type Move, moveOf, placeOf, type Reading, type Source, STILL } from "./source.ts";

export class HandleSource implements Source {
  readonly name = "ghost";
  readonly isRate = false;
  private clutch = new Clutch({ smooth_s: 0, frozen_s: Infinity, mayJump: true }); // a mouse tells where it is, at any speed
  private hand: Rigid = HOME;
  private isOver = false;
  private readonly letGo: () => void;

  /** `letGo`: makes the view end the drag. */
  constructor(letGo: () => void) {
    this.letGo = letGo;
  }

  take(): void {
    this.hand = HOME;
    this.isOver = false;
    this.clutch.engage(HOME);
  }

  /** The handles were dragged so far since they were taken. */
  drag(by: Move): void {
    this.hand = placeOf(by);
  }

  /** The pointer was released; the next reading is the last one. */
  release(): void {
    this.isOver = true;
  }

  read(elapsed_s: number): Reading | null {
    const change = this.clutch.move(this.hand, elapsed_s);
    if (!change) return null;
    const clutch = !this.isOver;
    if (this.isOver) this.clutch.release();
    return { by: moveOf(change), clutch, grip: "" };
  }

  forget(): void {
    if (!this.clutch.engaged) return;
    this.clutch.release();
    this.letGo();
  }
}

/** A control that only holds: while it is pressed the arm follows what moves the ghost. */
export class HoldSource implements Source {
  readonly name = "button";
  readonly isRate = true;
  private held = false;

  hold(held: boolean): void {
    this.held = held;
  }

  read(): Reading | null {
    return this.held ? { by: STILL, clutch: true, grip: "" } : null;
  }

  forget(): void {
    this.held = false;
  }
}
