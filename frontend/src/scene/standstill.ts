/** Notices that a page stood still: what a hand did meanwhile is not known, so nothing that it held goes on. */
export const LONGEST_MS = 1000;

export class Standstill {
  private last = -Infinity;
  private readonly now: () => number;

  /** `now`: a clock (ms) that runs on while the page stands still. */
  constructor(now: () => number) {
    this.now = now;
  }

  /** Begin to watch. */
  begin(): void {
    this.last = this.now();
  }

  /** Return whether the page stood still since the last call. Call it often, also when nothing happens. */
  noticed(): boolean {
    const before = this.last;
    this.last = this.now();
    return this.last - before > LONGEST_MS;
  }
}

/** Return whether a repeated key was pressed long ago: keys that wait while a page stands still come all at once. */
export function isStale(event: Pick<KeyboardEvent, "repeat" | "timeStamp">, now: number): boolean {
  return event.repeat && now - event.timeStamp > LONGEST_MS / 4;
}
