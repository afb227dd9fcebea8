/** A serial arm of revolute joints: poses of its links, Jacobian, limits (robots/kit/arms/chain.py). */
import type { ArmFacts, JointFacts } from "./facts.ts";
import { degrees, fixed, general } from "./words.ts";

/** A pose in the frame of the base, 4 x 4, row by row. Code that reads one needs the first 12 numbers only. */
export type Pose = ArrayLike<number>;
/** Angles or speeds of all joints (rad, rad/s). */
export type Joints = ArrayLike<number>;

export const FRAME = 12; // numbers of a pose in `frames`: the upper three rows

/** Write the product of two poses into `out` from `at` on: 12 numbers each, `a` from `i`, `b` from `j` on. */
export function multiply(a: Pose, i: number, b: Pose, j: number, out: Float64Array, at: number): void {
  for (let row = 0; row < 3; row++) {
    const r = i + 4 * row,
      x = a[r]!,
      y = a[r + 1]!,
      z = a[r + 2]!,
      to = at + 4 * row;
    out[to] = x * b[j]! + y * b[j + 4]! + z * b[j + 8]!;
    out[to + 1] = x * b[j + 1]! + y * b[j + 5]! + z * b[j + 9]!;
    out[to + 2] = x * b[j + 2]! + y * b[j + 6]! + z * b[j + 10]!;
    out[to + 3] = x * b[j + 3]! + y * b[j + 7]! + z * b[j + 11]! + a[r + 3]!;
  }
}

export class Chain {
  readonly joints: readonly JointFacts[];
  readonly tool: Pose;
  /** For each joint three poses: its transform is the first + cos q times the second + sin q times the third. */
  private readonly parts: Float64Array;
  private readonly step = new Float64Array(FRAME);

  constructor(facts: Pick<ArmFacts, "joints"> & { motion: Pick<ArmFacts["motion"], "tool"> }) {
    this.joints = facts.joints;
    this.tool = Float64Array.from(facts.motion.tool);
    this.parts = new Float64Array(3 * FRAME * this.joints.length);
    this.joints.forEach((joint, n) => {
      for (const [k, part] of rodrigues(joint.axis).entries()) multiply(joint.origin, 0, part, 0, this.parts, FRAME * (3 * n + k));
      for (let row = 0; row < 3; row++) for (const k of [1, 2]) this.parts[FRAME * (3 * n + k) + 4 * row + 3] = 0; // the offset is a part of the first only
    });
  }

  get count(): number {
    return this.joints.length;
  }

  /** Return the poses of each joint's frame, turned, and of the tool: n + 1 times 12 numbers. */
  frames(q: Joints, out: Float64Array = new Float64Array(FRAME * (this.count + 1))): Float64Array {
    const { parts, step } = this;
    for (let n = 0; n < this.count; n++) {
      const c = Math.cos(q[n]!),
        s = Math.sin(q[n]!),
        from = 3 * FRAME * n,
        into = n ? step : out;
      for (let k = 0; k < FRAME; k++) into[k] = parts[from + k]! + c * parts[from + FRAME + k]! + s * parts[from + 2 * FRAME + k]!;
      if (n) multiply(out, FRAME * (n - 1), step, 0, out, FRAME * n);
    }
    multiply(out, FRAME * (this.count - 1), this.tool, 0, out, FRAME * this.count);
    return out;
  }

  /** Return the pose of the tool, 16 numbers. */
  forward(q: Joints): Float64Array {
    const pose = new Float64Array(16);
    pose.set(this.frames(q).subarray(FRAME * this.count));
    pose[15] = 1;
    return pose;
  }

  /** Return the columns of the Jacobian, n times 6 numbers: the tool's velocity, then its rate of turning, in the base's frame. */
  jacobian(q: Joints): Float64Array {
    const frames = this.frames(q),
      columns = new Float64Array(6 * this.count),
      tip = FRAME * this.count;
    for (let n = 0; n < this.count; n++) {
      const at = FRAME * n,
        [u = 0, v = 0, w = 0] = this.joints[n]!.axis;
      const x = frames[at]! * u + frames[at + 1]! * v + frames[at + 2]! * w,
        y = frames[at + 4]! * u + frames[at + 5]! * v + frames[at + 6]! * w,
        z = frames[at + 8]! * u + frames[at + 9]! * v + frames[at + 10]! * w;
      const dx = frames[tip + 3]! - frames[at + 3]!,
        dy = frames[tip + 7]! - frames[at + 7]!,
        dz = frames[tip + 11]! - frames[at + 11]!;
      columns.set([y * dz - z * dy, z * dx - x * dz, x * dy - y * dx, x, y, z], 6 * n);
    }
    return columns;
  }

  /** Return a sentence that names the first joint outside its limits; empty if all are inside. */
  brokenLimit(q: Joints, slack = 1e-9): string {
    for (const [n, { name, low, high }] of this.joints.entries()) {
      const value = q[n]!;
      if (low - slack <= value && value <= high + slack) continue;
      const at = degrees(value),
        there = Math.abs(at) < 1e6 ? fixed(at, 1) : general(at, 3);
      return `joint ${name} would be at ${there}°, outside ${fixed(degrees(low), 1)}° to ${fixed(degrees(high), 1)}°`;
    }
    return "";
  }
}

/** Return the three parts of a rotation about `axis` as poses (Rodrigues). */
function rodrigues(axis: readonly number[]): number[][] {
  const [x = 0, y = 0, z = 0] = axis;
  return [
    [x * x, x * y, x * z, 0, x * y, y * y, y * z, 0, x * z, y * z, z * z, 0],
    [1 - x * x, -x * y, -x * z, 0, -x * y, 1 - y * y, -y * z, 0, -x * z, -y * z, 1 - z * z, 0],
    [0, -z, y, 0, z, 0, -x, 0, -y, x, 0, 0],
  ];
}
