/**
 * Subproblems of inverse kinematics with a geometric solution: one angle each (Paden 1986 and Kahan; in the form of
 * A. J. Elias and J. T. Wen, "IK-Geo: Unified robot inverse kinematics using subproblem decomposition", 2025, which is
 * that of EAIK, with which Python solves). Where there is no solution, the angle of least squares is returned. Axes `k` have unit length; angles in rad.
 */
import { cross, dot, minus, times, type Vec3 } from "./vectors.ts";

/** Return the angle that turns `p` about `k` onto `goal`: R(k, angle) p = goal. */
export function ontoPoint(k: Vec3, p: Vec3, goal: Vec3): number {
  const across = cross(k, p),
    inward = cross(k, across);
  return Math.atan2(dot(across, goal), -dot(inward, goal));
}

/** Return the angles at which `p`, turned about `k`, is so far from `centre`: |R(k, angle) p - centre| = distance. */
export function ontoSphere(k: Vec3, p: Vec3, centre: Vec3, distance: number): number[] {
  const gap = minus(centre, times(k, dot(k, p))),
    across = cross(k, p);
  return onLine(k, p, times(centre, -2), distance * distance - dot(gap, gap) - dot(across, across));
}

/** Return the angles at which `p`, turned about `k`, lies in a plane: h . R(k, angle) p = distance. */
export function ontoPlane(k: Vec3, p: Vec3, h: Vec3, distance: number): number[] {
  return onLine(k, p, h, distance - dot(h, k) * dot(k, p));
}

/** Solve h . (sin p' + cos p'') = b for the angle, p' and p'' being the parts of the turned `p` across `k`. */
function onLine(k: Vec3, p: Vec3, h: Vec3, b: number): number[] {
  const across = cross(k, p),
    inward = cross(k, across);
  const s = dot(h, across),
    c = -dot(h, inward),
    room = s * s + c * c - b * b;
  if (!(room > 0)) return [Math.atan2(s * b, c * b)];
  const far = Math.sqrt(room);
  return [Math.atan2(s * b + far * c, c * b - far * s), Math.atan2(s * b - far * c, c * b + far * s)];
}
