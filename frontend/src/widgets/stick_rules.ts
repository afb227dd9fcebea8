/** What a stick is pushed to: x to the right and y up, each from -1 to 1. */
import type { Pad } from "./gamepad.ts";

export type Push = readonly [number, number];
export const REST: Push = [0, 0];
const DEAD = 0.08; // a pointer this near to the middle pushes nothing
const TREMBLE = 0.15; // the same of a gamepad's axis
const BY_KEYS = 0.6; // a key gives no degrees; with Shift it is all
const GIVES = 0.7; // the share of its way by which a knob gives way to all the force
const SLOW_S = 1.5,
  BACK_S = 0.4; // how long a knob takes that comes against all the force, and one that is pushed back
const KEYS: Record<string, Push> = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };

/** Whether a key pushes the stick. */
export function isStickKey(key: string): boolean {
  return Object.hasOwn(KEYS, key);
}

/** A pointer so far from the middle (right, down), on a stick of that radius. */
export function byPointer(right: number, down: number, radius: number): Push {
  const far = Math.hypot(right, down) / radius;
  if (!(radius > 0) || !Number.isFinite(far)) return REST;
  const share = (way: number): number => {
    const pushed = way / radius / Math.max(1, far);
    return Math.abs(pushed) < DEAD ? 0 : (Math.sign(pushed) * (Math.abs(pushed) - DEAD)) / (1 - DEAD);
  };
  return [share(right), share(-down)];
}

/** The arrow keys that are held; null for none. */
export function byKeys(held: ReadonlySet<string>, all: boolean): Push | null {
  const ways = [...held].flatMap((key) => (isStickKey(key) ? [KEYS[key]!] : []));
  if (!ways.length) return null;
  const clipped = (v: number): number => Math.max(-1, Math.min(1, v)) * (all ? 1 : BY_KEYS);
  return [clipped(ways.reduce((sum, [x]) => sum + x, 0)), clipped(ways.reduce((sum, [, y]) => sum + y, 0))];
}

/** A gamepad's left stick by degrees, or its cross; null at rest. */
export function byPad(pad: Pad | null): Push | null {
  if (!pad?.connected) return null;
  const down = (i: number): number => (pad.buttons[i]?.pressed ? BY_KEYS : 0);
  const axis = (v: number | undefined): number =>
    v === undefined || !Number.isFinite(v) || Math.abs(v) < TREMBLE
      ? 0
      : (Math.sign(v) * (Math.min(1, Math.abs(v)) - TREMBLE)) / (1 - TREMBLE);
  const clipped = (v: number): number => Math.max(-1, Math.min(1, v));
  const push: Push = [clipped(axis(pad.axes[0]) + down(15) - down(14)), clipped(-axis(pad.axes[1]) + down(12) - down(13))];
  return push[0] === 0 && push[1] === 0 ? null : push;
}

/**
 * Where a knob is after so many seconds that is pushed to `wanted`, against a force from 0 to 1. The force acts against
 * a push ahead alone: the knob comes the later the greater it is, stays short of `wanted`, and is pushed back where it has
 * come farther. It is drawn back and turned at once.
 */
export function dampedPush([, y]: Push, wanted: Push, resistance: number, seconds: number): Push {
  const force = Math.max(0, Math.min(1, Number.isFinite(resistance) ? resistance : 0));
  if (wanted[1] <= 0 || force === 0) return wanted;
  const from = Math.max(0, Math.min(y, wanted[1])),
    to = wanted[1] * (1 - GIVES * force);
  const takes = from < to ? SLOW_S * force : BACK_S;
  return [wanted[0], from + (to - from) * (1 - Math.exp(-Math.max(0, seconds) / takes))];
}
