/**
 * The reports of a 6D mouse (USB HID, usage "multi-axis controller"), as 3Dconnexion's devices send them: report 1 has the
 * place of the cap along x (right), y (towards the person), z (down), report 2 its turn about them, each as three signed
 * 16-bit numbers, the low byte first; newer devices send all six in report 1. Report 3 has a bit for each button. Others,
 * as that of the battery, and reports of another length say nothing.
 */
import type { Move } from "./source.ts";

/** How far the cap is pushed and turned, as shares of its range about the base's axes, and its buttons. */
export interface Cap {
  push: Move;
  buttons: number; // a bit each, the first one is 1
}

export const REST: Cap = { push: [0, 0, 0, 0, 0, 0], buttons: 0 };
export const FILTER = { usagePage: 1, usage: 8 }; // a multi-axis controller
const RANGE = 350; // of each number, by the maker's data
const DEAD = 0.07; // share of it within which a cap counts as at rest
const PLACE = 1,
  TURN = 2,
  BUTTONS = 3;
const THREE = 6, // bytes
  SIX = 12,
  MOST = 64;

/** Return the cap after a report. */
export function capAfter(cap: Cap, report: number, data: DataView): Cap {
  const { byteLength } = data;
  if (byteLength > MOST) return cap;
  const [x, y, z, u, v, w] = cap.push;
  if (report === PLACE && byteLength >= SIX) return { ...cap, push: [...three(data, 0), ...three(data, THREE)] };
  if (report === PLACE && byteLength === THREE) return { ...cap, push: [...three(data, 0), u, v, w] };
  if (report === TURN && byteLength === THREE) return { ...cap, push: [x, y, z, ...three(data, 0)] };
  if (report === BUTTONS && byteLength >= 1) return { ...cap, buttons: data.getUint8(0) };
  return cap;
}

/** Return three numbers about the base's axes (x away from the base, y to the left, z up). */
function three(data: DataView, from: number): [number, number, number] {
  const [right, near, down] = [0, 2, 4].map((at) => share(data.getInt16(from + at, true)));
  return [-near!, -right!, -down!];
}

function share(raw: number): number {
  const pushed = Math.max(-1, Math.min(1, raw / RANGE)),
    beyond = Math.max(0, Math.abs(pushed) - DEAD) / (1 - DEAD);
  return beyond && Math.sign(pushed) * beyond;
}
