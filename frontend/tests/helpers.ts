/** What several tests need: vectors and packets, a browser's globals, places in queues, gamepads. */
import { readFileSync } from "node:fs";
import type { QueuePlace } from "../src/queue/person_socket.ts";
import type { ObjectFacts } from "../src/scene/known.ts";
import type { Placed } from "../src/socket/objects.ts";
import type { Pad } from "../src/widgets/gamepad.ts";

/** Read the vectors that Python and TypeScript share. */
export function vectorsOf<T>(name: string): T {
  return JSON.parse(readFileSync(new URL(`../../tests/vectors/${name}.json`, import.meta.url), "utf-8")) as T;
}

export function bytesOf(hex: string): Uint8Array<ArrayBuffer> {
  return Uint8Array.from(Buffer.from(hex, "hex"));
}

/** Return a source of random numbers between two values that is the same for a seed (mulberry32). */
export function seededDraw(seed: number): (low: number, high: number) => number {
  let state = seed;
  return (low, high) => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return low + (high - low) * (((t ^ (t >>> 14)) >>> 0) / 2 ** 32);
  };
}

/** Give the test's modules these globals; import what uses them afterwards. */
export function stub(values: object): void {
  for (const [name, value] of Object.entries(values))
    Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
}

export function queuePlace(more: Partial<QueuePlace>): QueuePlace {
  const none = { until_ms: null, kept_until_ms: null, ended_ms: null, wait_s: null, idle_ms: null, end: null, turn: null };
  return { ...none, state: "waiting", ticket: 1, robot: "mercury", name: "Mercury", ahead: 0, away: false, ...more };
}

/** Return facts of a box that may carry everything and is grasped from above. */
export function boxFacts(
  name: string,
  number: number,
  more: Pick<ObjectFacts, "size" | "turns" | "grasps"> & Partial<ObjectFacts>,
): ObjectFacts {
  return { name, number, shape: "box", colour: [1, 0, 0], carries: ["*"], ...more };
}

export function gamepad(axes: number[], pressed: number[] = [], connected = true): Pad {
  const buttons = Array.from({ length: 17 }, (_, i) => ({ pressed: pressed.includes(i), touched: false, value: 0 }));
  return { axes, connected, buttons };
}

/** Let promises come true that wait for nothing else; timers stand still meanwhile. */
export async function settled(): Promise<void> {
  for (let i = 0; i < 50; i++) await Promise.resolve();
}

/** Return 12 bytes an object, as robots/kit/contract/objects.py writes them. */
export function objectPacket(
  objects: readonly (readonly [number, Placed])[],
  box: Readonly<{ low: readonly number[]; size: readonly number[] }>,
): Uint8Array {
  const words = objects.map(([number, { place, rotation, held }]) => {
    const largest = rotation.map(Math.abs).indexOf(Math.max(...rotation.map(Math.abs))),
      sign = Math.sign(rotation[largest]!),
      others = rotation.filter((_, n) => n !== largest).map((one) => one * sign);
    let bits = BigInt(number);
    const put = (value: number, size: number): void => void (bits = (bits << BigInt(size)) | BigInt(Math.round(value)));
    const turns = (steps: number, size: number): void => others.forEach((one) => put(((one + Math.SQRT1_2) / Math.SQRT2) * steps, size)); // prettier-ignore
    if (held) {
      put(65535, 16);
      put(1, 1);
      place.forEach((at) => put(((at + 0.256) / 0.512) * 4095, 12));
      put(largest, 2);
      turns(2046, 11);
      put(0, 1);
    } else {
      place.forEach((at, n) => put(((at - box.low[n]!) / box.size[n]!) * 65534, 16));
      put(largest, 2);
      turns(8190, 13);
    }
    return bits.toString(16).padStart(24, "0");
  });
  return bytesOf(words.join(""));
}
