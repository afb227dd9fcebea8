/** Poses as 16 numbers, 4 x 4 row by row: products, inverses, and from a place with a quaternion. */
import { multiply, type Pose } from "../motion/chain.ts";
import { poseOf } from "../motion/rigid.ts";

/** Return the product of two poses. */
export function product(a: Pose, b: Pose): Float64Array {
  const out = new Float64Array(16);
  multiply(a, 0, b, 0, out, 0);
  out[15] = 1;
  return out;
}

/** Return the inverse of a rigid pose. */
export function inverse(a: Pose): Float64Array {
  const out = new Float64Array(16);
  for (let row = 0; row < 3; row++) {
    for (let column = 0; column < 3; column++) out[4 * row + column] = a[4 * column + row]!;
    out[4 * row + 3] = -(a[row]! * a[3]! + a[4 + row]! * a[7]! + a[8 + row]! * a[11]!);
  }
  out[15] = 1;
  return out;
}

/** Return the pose at a place (m), turned by a quaternion (x, y, z, w; of unit length). */
export function poseAt([x = 0, y = 0, z = 0]: readonly number[], [a = 0, b = 0, c = 0, d = 1]: readonly number[]): Float64Array {
  return poseOf({ at: [x, y, z], turn: [a, b, c, d] });
}

/** Return the poses at which an object looks as at this one: after each of so many equal turns about its own z. */
export function alike(pose: Pose, turns: number): Float64Array[] {
  return Array.from({ length: turns }, (_, n) => product(pose, uprightAt([0, 0, 0], (2 * Math.PI * n) / turns)));
}

/** Return a place (m), turned about the vertical by an angle (rad). */
export function uprightAt(place: readonly number[], angle: number): Float64Array {
  return poseAt(place, [0, 0, Math.sin(angle / 2), Math.cos(angle / 2)]);
}
