/** How far a stick is pushed: x to the right and y up, each from -1 to 1. */
import type { Pad } from "./gamepad.ts";

export type Push = readonly [number, number];
export const REST: Push = [0, 0];
const DEAD = 0.08; // a pointer nearer to the middle than this does not push
const TREMBLE = 0.15; // the same for the axis of a gamepad
const BY_KEYS = 0.6; // the push of a key; with Shift it is 1
const GIVES = 0.7; // the share of the push by which the whole force moves a knob back
const SLOW_S = 1.5,
  BACK_S = 0.4; // the time constants of a knob that moves against the whole force, and of one that is pushed back
const KEYS: Record<string, Push> = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };

/** Whether a key pushes the stick. */
export function isStickKey(key: string): boolean {
  return Object.hasOwn(KEYS, key);
}

/** Return the push of a pointer at that distance from the middle, on a stick of that radius (px). */
export function byPointer(right: number, down: number, radius: number): Push {
  const far = Math.hypot(right, down) / radius;
  if (!(radius > 0) || !Number.isFinite(far)) return REST;
  const share = (way: number): number => {
    const pushed = way / radius / Math.max(1, far);
    return Math.abs(pushed) < DEAD ? 0 : (Math.sign(pushed) * (Math.abs(pushed) - DEAD)) / (1 - DEAD);
  };
  return [share(right), share(-down)];
}

/** Return the push of the arrow keys that are held; null for none. */
export function byKeys(held: ReadonlySet<string>, all: boolean): Push | null {
  const ways = [...held].flatMap((key) => (isStickKey(key) ? [KEYS[key]!] : []));
  if (!ways.length) return null;
  const clipped = (v: number): number => Math.max(-1, Math.min(1, v)) * (all ? 1 : BY_KEYS);
  return [clipped(ways.reduce((sum, [x]) => sum + x, 0)), clipped(ways.reduce((sum, [, y]) => sum + y, 0))];
}

/** Return the push of a gamepad's left stick or cross; null at rest. */
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
 * Return the place of a knob after so many seconds, pushed to `wanted` against a force (`resistance`) from 0 to 1. The
 * force acts only against a push ahead: it slows the knob down, keeps it short of `wanted`, and pushes it back if it is
 * farther. A push back or to the side takes effect at once.
 */
export function dampedPush([, y]: Push, wanted: Push, resistance: number, seconds: number): Push {
  const force = Math.max(0, Math.min(1, Number.isFinite(resistance) ? resistance : 0));
  if (wanted[1] <= 0 || force === 0) return wanted;
  const from = Math.max(0, Math.min(y, wanted[1])),
    to = wanted[1] * (1 - GIVES * force);
  const takes = from < to ? SLOW_S * force : BACK_S;
  return [wanted[0], from + (to - from) * (1 - Math.exp(-Math.max(0, seconds) / takes))];
}
