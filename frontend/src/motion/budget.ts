/** The limit of work for one plan (robots/kit/arms/budget.py): a page must not stand still over a motion. */
export const MOST = 8000;
export const SHARED = 80; // answers at a singular pose
export const LOOK = 15; // one check of the boxes;
export const GLANCED_AT = 0.5; // each posture in it, checked coarsely
export const LOOKED_AT = 1.5; // or exactly
export const MOTION = 25; // other work of a motion

/** A motion is not planned; `code` is `range` for limits, reach and work, `box` for boxes, otherwise `busy`. */
export class Refused extends Error {
  readonly code: "range" | "box" | "busy";

  constructor(code: "range" | "box" | "busy", text: string) {
    super(text);
    this.code = code;
  }
}

export class Budget {
  private remaining = MOST;

  /** Use so much of it. Throws Refused. */
  spend(units: number): void {
    this.remaining -= units;
    if (this.remaining < 0)
      throw new Refused("range", "this is more than may be planned at once: about 10 m of straight lines, or 150 motions that differ");
  }
}
