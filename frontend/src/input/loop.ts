/** Reads all sources 25 times a second, and notices a page that stood still: what a hand did meanwhile is not known. */
import { type Grip, isStill, type Move, type Source } from "./source.ts";

export const LONGEST_MS = 1000;
export const TICK_MS = 40;

/** What sources do with the ghost. */
export interface LoopUse {
  /** A hand takes the ghost. */
  taken(source: Source): void;
  moved(source: Source, by: Move): void;
  released(source: Source): void;
  /** The control that has to be held while the arm follows was pressed, and released. */
  held(source: Source): void;
  letGo(source: Source): void;
  /** A button of the gripper was pressed while the arm's control was held. */
  grip(grip: "close" | "open"): void;
  /** The page stood still, so all hands let go. `wasUsed`: whether one used the ghost. */
  stoodStill(wasUsed: boolean): void;
}

export class Loop {
  private using = new Set<Source>();
  private holder: Source | null = null; // whose control is held
  private pressed = new Map<Source, Grip>();
  private last: number;
  private isBusy = false; // what a hand's end causes reads no source again
  private readonly sources: readonly Source[];
  private readonly use: LoopUse;
  private readonly now: () => number;

  /** `now`: a clock (ms) that runs on while the page stands still. */
  constructor(sources: readonly Source[], use: LoopUse, now: () => number) {
    [this.sources, this.use, this.now] = [sources, use, now];
    this.last = now();
  }

  /** Read all sources; called often, also when nothing happens. */
  tick(): void {
    this.alone(() => this.step());
  }

  private alone(act: () => void): void {
    if (this.isBusy) return;
    this.isBusy = true;
    try {
      act();
    } finally {
      this.isBusy = false;
    }
  }

  private step(): void {
    const now = this.now(),
      elapsed = now - this.last;
    this.last = now;
    if (elapsed > LONGEST_MS) {
      const wasUsed = this.using.size > 0;
      this.endAll();
      this.use.stoodStill(wasUsed);
    } else for (const source of this.sources) this.read(source, elapsed / 1000);
  }

  private read(source: Source, elapsed_s: number): void {
    const reading = source.read(elapsed_s);
    if (!reading) return this.end(source);
    if (!this.using.has(source)) {
      this.using.add(source);
      this.pressed.set(source, reading.grip); // a button that was pressed before counts once it is pressed again
      this.use.taken(source);
    }
    if (reading.clutch && !this.holder) {
      this.holder = source;
      this.use.held(source);
    }
    if (!isStill(reading.by) && this.using.has(source)) this.use.moved(source, reading.by);
    if (source === this.holder) this.grip(source, reading.grip);
    this.pressed.set(source, reading.grip);
    if (!reading.clutch) this.endHold(source);
  }

  private grip(source: Source, grip: Grip): void {
    if (grip && grip !== this.pressed.get(source)) this.use.grip(grip);
  }

  private endHold(source: Source): void {
    if (source !== this.holder) return;
    this.holder = null;
    this.use.letGo(source);
  }

  private end(source: Source): void {
    if (!this.using.delete(source)) return;
    this.endHold(source);
    this.use.released(source);
  }

  /** Make all hands let go: each has to take the ghost again. */
  drop(): void {
    if (this.isBusy) this.endAll();
    else this.alone(() => this.endAll());
  }

  private endAll(): void {
    for (const source of this.sources) {
      source.forget();
      this.end(source);
    }
  }
}

/** Return whether a repeated key was pressed long ago: keys that wait while a page stands still come all at once. */
export function isStale(event: Pick<KeyboardEvent, "repeat" | "timeStamp">, now: number): boolean {
  return event.repeat && now - event.timeStamp > LONGEST_MS / 4;
}
