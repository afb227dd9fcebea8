/** Poses as matrices of three. */
import { Matrix4 } from "three";
import type { Pose } from "../motion/chain.ts";

/** Return a pose (4 x 4, row by row) as a matrix, whose numbers three keeps column by column. */
export function matrixOf(pose: Pose): Matrix4 {
  return new Matrix4().fromArray(Array.from({ length: 16 }, (_, i) => pose[i] ?? 0)).transpose();
}
