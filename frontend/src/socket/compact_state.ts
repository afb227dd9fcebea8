/** Reads compact states (robots/kit/contract/compact.py): whole steps of scales, bit by bit, the highest bit first. */
import type { CompactLayout, StatePacket } from "./packets.ts";

export type { CompactLayout } from "./packets.ts";

const CLOCK = 1 << 16; // ms after which the stamp begins again
const words = new TextDecoder();

/** Return a function that reads the next so many bits, from byte `at` on, the highest bit first. */
export function bitReader(data: Uint8Array, at: number): (bits: number) => number {
  let bit = at * 8;
  return (bits) => {
    let value = 0;
    for (const end = bit + bits; bit < end; bit++) value = value * 2 + ((data[bit >> 3]! >> (7 - (bit & 7))) & 1);
    return value;
  };
}

/** Decode a compact state; null for another layout. `nearMs`: server time, at most half a minute from the packet's. */
export function compactState(data: Uint8Array, layout: CompactLayout, nearMs: number): StatePacket | null {
  const modeBits = layout.modes.length ? layout.modes.length.toString(2).length : 0;
  const size = Math.ceil((26 + modeBits + layout.scales.reduce((sum, [, , bits]) => sum + bits, 0)) / 8);
  if (data.length < size || data[0] !== layout.mark) return null;
  const take = bitReader(data, 1);
  const stamp = take(16),
    moving = take(1) === 1,
    stopped = take(1) === 1,
    known = take(modeBits);
  const text = known === 2 ** modeBits - 1;
  if (known >= layout.modes.length && !text) return null;
  const numbers: number[] = [];
  for (const [low, step, bits, steps] of layout.scales) {
    const code = take(bits);
    if (code > steps && code !== 2 ** bits - 1) return null;
    numbers.push(code > steps ? NaN : low + code * step);
  }
  const near = Math.round(nearMs);
  const behind = ((((near - stamp + CLOCK / 2) % CLOCK) + CLOCK) % CLOCK) - CLOCK / 2;
  return {
    moving,
    stopped,
    number: 0,
    atMs: near - behind,
    joints: numbers.slice(0, layout.joints),
    velocities: [],
    torques: [],
    values: numbers.slice(layout.joints),
    mode: text ? words.decode(data.subarray(size)) : layout.modes[known]!,
  };
}
