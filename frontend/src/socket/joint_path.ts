/** Reads the path of a joint motion (robots/kit/contract/path_packet.py), and says where the joints are on it. */
import { bitReader } from "./compact_state.ts";
import type { CompactLayout, JointMotion, PathPacket } from "./packets.ts";

const HEAD_BITS = 99,
  LONGEST = 48, // bytes
  FEWEST_BITS = 8,
  MOST_BITS = 16, // of a position
  CLOCK = 2 ** 24, // ms after which the stamp begins again
  FASTEST = 2; // scales a second

/** Return the path in a packet; null for another layout. `nearMs`: server time, at most two hours from its beginning. */
export function jointPath(data: Uint8Array, layout: CompactLayout, nearMs: number): PathPacket | null {
  if (data.length * 8 <= HEAD_BITS || data.length > LONGEST || data[1] !== layout.mark) return null;
  const take = bitReader(data, 2);
  const command = take(32),
    stamp = take(24),
    ms = take(20),
    joints = take(4) + 1,
    count = take(2) + 2,
    moving = take(1),
    rows = count + moving;
  const bits = Math.min(MOST_BITS, Math.floor((8 * LONGEST - HEAD_BITS) / (rows * joints)));
  if (joints > layout.joints || bits < FEWEST_BITS || ms === 0 || data.length * 8 < HEAD_BITS + bits * rows * joints) return null;
  const scales = layout.scales.slice(0, joints),
    most = 2 ** bits - 1,
    half = 2 ** (bits - 1) - 1;
  const knots = Array.from({ length: count }, () => scales.map(([low, step, , steps]) => low + (take(bits) / most) * steps * step));
  const velocity = moving ? scales.map(([, step, , steps]) => ((take(bits) - half) / half) * FASTEST * steps * step) : [];
  const near = Math.round(nearMs),
    behind = ((((near - stamp + CLOCK / 2) % CLOCK) + CLOCK) % CLOCK) - CLOCK / 2;
  return { command, beganMs: near - behind, seconds: ms / 1000, knots, velocity };
}

/** Return where the joints (rad, m) are on a path, `t` s after its beginning; before it and after its end they rest. */
export function jointsAt({ knots, seconds, velocity }: JointMotion, t: number): number[] {
  const pieces = knots.length - 1,
    step = seconds / pieces,
    within = Math.min(Math.max(t, 0), seconds),
    first = Math.min(Math.floor(within / step), pieces - 1),
    s = within / step - first;
  const speeds = speedsAt(knots, velocity, step);
  return knots[first]!.map(
    (p, i) =>
      (2 * s ** 3 - 3 * s ** 2 + 1) * p +
      (s ** 3 - 2 * s ** 2 + s) * step * speeds[first]![i]! +
      (3 * s ** 2 - 2 * s ** 3) * knots[first + 1]![i]! +
      (s ** 3 - s ** 2) * step * speeds[first + 1]![i]!,
  );
}

/** Return the velocities at the knots, by which also the acceleration is continuous (Thomas' algorithm). */
function speedsAt(knots: number[][], velocity: number[], step: number): number[][] {
  const rest = knots[0]!.map(() => 0),
    rows = [velocity.length ? velocity : rest],
    factors: number[] = [];
  for (let n = 1; n < knots.length - 1; n++) {
    const pivot = 4 - (factors.at(-1) ?? 0),
      known = rows[n - 1]!;
    factors.push(1 / pivot);
    rows.push(rest.map((_, i) => ((3 * (knots[n + 1]![i]! - knots[n - 1]![i]!)) / step - known[i]!) / pivot));
  }
  rows.push(rest);
  for (let n = knots.length - 2; n > 0; n--) rows[n] = rows[n]!.map((known, i) => known - factors[n - 1]! * rows[n + 1]![i]!);
  return rows;
}
