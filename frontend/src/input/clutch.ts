/**
 * The clutch between a hand and the ghost of the tool: while it is engaged the ghost moves as the hand does, from where
 * it is. Only changes of the hand count, and the filter starts anew, so that no engagement makes a jump.
 */
import { between, type Change, moved, type Rigid } from "../motion/rigid.ts";
import { norm, times } from "../motion/vectors.ts";

/** A hand that is so far away at once is another one, or is not tracked (robots/kit/arms/follow.py has the same). */
export const JUMP_M = 0.1,
  JUMP_RAD = 0.8;
export const FROZEN_S = 0.25; // after so long without a place what the hand did meanwhile is not done
const STEP_S = 0.05; // the filter counts no step as longer
const NONE: Change = { way: [0, 0, 0], turn: [0, 0, 0] };

export interface ClutchSettings {
  smooth_s?: number; // time constant of the filter; 0: none
  frozen_s?: number;
  mayJump?: boolean;
}

/** Return whether a hand that has gone so far at once is lost. */
export function isJump({ way, turn }: Change): boolean {
  return !(norm(way) <= JUMP_M && norm(turn) <= JUMP_RAD);
}

export class Clutch {
  private last: Rigid | null = null; // of the hand,
  private smooth: Rigid | null = null; // filtered
  private readonly settings: Required<ClutchSettings>;

  constructor({ smooth_s = 0.02, frozen_s = FROZEN_S, mayJump = false }: ClutchSettings = {}) {
    this.settings = { smooth_s, frozen_s, mayJump };
  }

  get engaged(): boolean {
    return this.last !== null;
  }

  /** Take the hand's place afresh. Returns whether it is one. */
  engage(hand: Rigid): boolean {
    if (!isPlace(hand)) return false;
    this.last = this.smooth = hand;
    return true;
  }

  release(): void {
    this.last = this.smooth = null;
  }

  /** Return by how much the ghost shall move now; null if the clutch is not engaged, or the hand jumped, which releases it. */
  move(hand: Rigid, elapsed_s: number): Change | null {
    const { last, smooth, settings } = this;
    if (!last || !smooth) return null;
    if (!isPlace(hand) || Number.isNaN(elapsed_s) || (!settings.mayJump && isJump(between(last, hand)))) {
      this.release();
      return null;
    }
    this.last = hand;
    if (elapsed_s > settings.frozen_s || elapsed_s < 0) {
      this.smooth = hand;
      return NONE;
    }
    const share = settings.smooth_s ? 1 - Math.exp(-Math.min(elapsed_s, STEP_S) / settings.smooth_s) : 1,
      { way, turn } = between(smooth, hand),
      change = { way: times(way, share), turn: times(turn, share) };
    this.smooth = moved(smooth, change);
    return change;
  }
}

function isPlace({ at, turn }: Rigid): boolean {
  return [...at, ...turn].every(Number.isFinite) && Math.abs(Math.hypot(...turn) - 1) < 1e-6;
}
