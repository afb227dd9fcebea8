/** Vectors of three numbers; each function returns a new one. */
export type Vec3 = readonly [number, number, number];

export const minus = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const plus = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const times = (a: Vec3, share: number): Vec3 => [a[0] * share, a[1] * share, a[2] * share];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vec3, b: Vec3): Vec3 => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const norm = (a: Vec3): number => Math.hypot(a[0], a[1], a[2]);

/** Return `v` turned by `angle` (rad) about the unit vector `axis` (Rodrigues). */
export function turned(axis: Vec3, angle: number, v: Vec3): Vec3 {
  const c = Math.cos(angle),
    s = Math.sin(angle),
    along = dot(axis, v) * (1 - c);
  const [x, y, z] = cross(axis, v);
  return [c * v[0] + s * x + along * axis[0], c * v[1] + s * y + along * axis[1], c * v[2] + s * z + along * axis[2]];
}
