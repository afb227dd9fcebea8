/** When pieces of sound are played: a little after they came, evenly, and never farther and farther behind. */

export const DELAY_S = 0.18; // a piece that comes after silence is played with this delay
export const MAX_DELAY_S = 0.3; // with a longer delay than this the waiting pieces are dropped

/** When a piece is played: `at` (s, of the audio clock), null to leave it out; `drop`: drop the pieces that still wait. */
interface Due {
  at: number | null;
  drop: boolean;
}

/** The time line of one listener; the number of a piece gives its place, so that a missing piece stays silent. */
export class PlayoutBuffer {
  private run = -1;
  private newest = -1; // number of the last piece
  private end = 0; // when the last piece ends, s

  /** Take a piece of `seconds` that has come at the time `now` (s, of the audio clock). */
  take(piece: { run: number; number: number; seconds: number }, now: number): Due {
    const missing = piece.number - this.newest - 1;
    const same = piece.run === this.run;
    if (same && missing < 0 && missing > -1000) return { at: null, drop: false }; // it is late
    const at = this.end + Math.max(0, missing) * piece.seconds;
    const follows = same && missing >= 0 && at >= now && at <= now + MAX_DELAY_S;
    const begin = follows ? at : now + DELAY_S;
    this.run = piece.run;
    this.newest = piece.number;
    this.end = begin + piece.seconds;
    return { at: begin, drop: !follows };
  }

  forget(): void {
    this.run = -1;
    this.newest = -1;
    this.end = 0;
  }
}
