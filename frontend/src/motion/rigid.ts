/** A pose as a place (m) and a quaternion (x, y, z, w; unit length), which stays a rotation however often it is changed. */
import type { Pose } from "./chain.ts";
import { quaternionOf, turnOf } from "./linear.ts";
import { cross, minus, norm, plus, times, type Vec3 } from "./vectors.ts";

export type Quaternion = readonly [number, number, number, number];
export interface Rigid {
  at: Vec3;
  turn: Quaternion;
}
/** A motion: its way (m) and its turn (axis times angle, rad). */
export interface Change {
  way: Vec3;
  turn: Vec3;
}

export function product(a: Quaternion, b: Quaternion): Quaternion {
  const u: Vec3 = [a[0], a[1], a[2]],
    v: Vec3 = [b[0], b[1], b[2]],
    [x, y, z] = plus(plus(times(v, a[3]), times(u, b[3])), cross(u, v)),
    w = a[3] * b[3] - u[0] * v[0] - u[1] * v[1] - u[2] * v[2],
    size = Math.hypot(x, y, z, w);
  return [x / size, y / size, z / size, w / size];
}

/** Return the turn from `a` to `b` as axis times angle (rad), by half a turn at most. */
function turnBetween(a: Quaternion, b: Quaternion): Vec3 {
  const [x = 0, y = 0, z = 0] = turnOf(product(b, [-a[0], -a[1], -a[2], a[3]]));
  return [x, y, z];
}

/** Return a rotation turned on by axis times angle (rad). */
export function turnedBy(a: Quaternion, turn: Vec3): Quaternion {
  const angle = norm(turn),
    [x, y, z] = times(turn, angle > 1e-12 ? Math.sin(angle / 2) / angle : 0.5);
  return product([x, y, z, Math.cos(angle / 2)], a);
}

/** Return the motion from one pose to another: place (m) and turn (rad). */
export function between(a: Rigid, b: Rigid): { way: Vec3; turn: Vec3 } {
  return { way: minus(b.at, a.at), turn: turnBetween(a.turn, b.turn) };
}

export function moved({ at, turn }: Rigid, by: { way: Vec3; turn: Vec3 }, share = 1): Rigid {
  return { at: plus(at, times(by.way, share)), turn: turnedBy(turn, times(by.turn, share)) };
}

/** Return the pose as 16 numbers, row by row. */
export function poseOf({ at, turn: [x, y, z, w] }: Rigid): Float64Array {
  return Float64Array.of(
    1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), at[0],
    2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), at[1],
    2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), at[2],
    0, 0, 0, 1,
  ); // prettier-ignore
}

export function rigidOf(pose: Pose): Rigid {
  const [x = 0, y = 0, z = 0, w = 1] = quaternionOf((row, column) => pose[4 * row + column]!);
  return { at: [pose[3]!, pose[7]!, pose[11]!], turn: [x, y, z, w] };
}
