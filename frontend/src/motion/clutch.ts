/**
 * The clutch between a hand (mouse, finger, controller) and the ghost of the tool: while it is engaged, the ghost moves as
 * the hand does, scaled down, from where it is. Only changes of the hand count, so that no engagement makes a jump.
 */
import { between, isFinitePose, moved, type Rigid } from "./rigid.ts";
import { norm, times, type Vec3 } from "./vectors.ts";

export const JUMP_M = 0.1; // a hand that is so far away at once is not the same hand, or is not tracked
export const FROZEN_S = 0.25; // after so long without a pose what the hand did meanwhile is not done
const SMOOTH_S = 0.02; // time constant of the filter
const STEP_S = 0.05; // the filter counts no step as longer
export const SCALES = [1, 10] as const;

/** By how much the ghost shall move: place (m) and turn (axis times angle, rad). */
export interface Change {
  way: Vec3;
  turn: Vec3;
}

export class Clutch {
  private last: Rigid | null = null; // of the hand,
  private smooth: Rigid | null = null; // filtered
  private at_s = 0;
  private scale = 1;

  get engaged(): boolean {
    return this.last !== null;
  }

  /** Take the hand's pose afresh, with a filter that starts anew. `scale`: so many times less moves the ghost, 1 to 10. */
  engage(hand: Rigid, now_s: number, scale = 1): boolean {
    if (!isFinitePose(hand) || !Number.isFinite(now_s)) return false;
    this.last = this.smooth = hand;
    this.at_s = now_s;
    this.scale = Math.min(Math.max(Number.isFinite(scale) ? scale : 1, SCALES[0]), SCALES[1]);
    return true;
  }

  release(): void {
    this.last = this.smooth = null;
  }

  /** Return by how much the ghost shall move now; null if the clutch is not engaged, or the hand jumped, which ends the grip. */
  move(hand: Rigid, now_s: number): Change | null {
    const { last, smooth } = this,
      elapsed = now_s - this.at_s;
    if (!last || !smooth) return null;
    if (!isFinitePose(hand) || !(norm(between(last, hand).way) <= JUMP_M) || !Number.isFinite(elapsed)) {
      this.release();
      return null;
    }
    this.last = hand;
    this.at_s = now_s;
    if (elapsed > FROZEN_S || elapsed < 0) {
      this.smooth = hand;
      return { way: [0, 0, 0], turn: [0, 0, 0] };
    }
    const share = 1 - Math.exp(-Math.min(elapsed, STEP_S) / SMOOTH_S),
      { way, turn } = between(smooth, hand);
    this.smooth = moved(smooth, { way, turn }, share);
    return { way: times(way, share / this.scale), turn: times(turn, share / this.scale) };
  }
}
