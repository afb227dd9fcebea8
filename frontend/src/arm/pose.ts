/** Poses as people write them (robots/kit/arms/pose.py). */
import { Euler, type Matrix4, Vector3 } from "three";

/** Return x, y, z (m) and roll, pitch, yaw (rad) about the fixed axes x, y, z in that order. */
export function numbersOf(pose: Matrix4): number[] {
  const at = new Vector3().setFromMatrixPosition(pose),
    turn = new Euler().setFromRotationMatrix(pose, "ZYX");
  return [at.x, at.y, at.z, turn.x, turn.y, turn.z];
}
