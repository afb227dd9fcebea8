/** The arm's planar kinematics for drawing, from the same description as everywhere. */

export interface Description {
  arm: { link1: number; link2: number; q2_deg: [number, number]; up: number; down: number };
  sand: { x: [number, number]; y: [number, number] };
  jog: { step: number };
}
export interface Arm {
  elbow: [number, number];
  tool: [number, number];
}

/** Return elbow and tool (m) of joints q1, q2 (rad). */
export function forward(d: Description, q: number[]): Arm {
  const [q1 = 0, q2 = 0] = q;
  const elbow: [number, number] = [d.arm.link1 * Math.cos(q1), d.arm.link1 * Math.sin(q1)];
  return { elbow, tool: [elbow[0] + d.arm.link2 * Math.cos(q1 + q2), elbow[1] + d.arm.link2 * Math.sin(q1 + q2)] };
}

/** Return the arm at a tool target (m), or null if it is out of reach. */
export function reach(d: Description, x: number, y: number): Arm | null {
  const { link1, link2 } = d.arm;
  const c = (x * x + y * y - link1 ** 2 - link2 ** 2) / (2 * link1 * link2);
  if (Math.abs(c) > 1) return null;
  const q2 = Math.acos(c);
  const q1 = Math.atan2(y, x) - Math.atan2(link2 * Math.sin(q2), link1 + link2 * Math.cos(q2));
  return forward(d, [q1, q2]);
}

export function onSand(d: Description, x: number, y: number): boolean {
  return x >= d.sand.x[0] && x <= d.sand.x[1] && y >= d.sand.y[0] && y <= d.sand.y[1];
}

export interface Map2 {
  matrix: number[][];
  theta: number;
}

/** Return the tool target (m) for a pixel, as the server computes it. */
export function target(map: Map2, pose: number[], u: number, v: number, w: number, h: number): [number, number] {
  const [[a = 0, b = 0, c = 0] = [], [d = 0, e = 0, f = 0] = []] = map.matrix;
  const pu = u - (w - 1) / 2,
    pv = v - (h - 1) / 2;
  const dx = a * pu + b * pv + c,
    dy = d * pu + e * pv + f;
  const turn = (pose[3] ?? 0) - map.theta;
  return [(pose[0] ?? 0) + Math.cos(turn) * dx - Math.sin(turn) * dy, (pose[1] ?? 0) + Math.sin(turn) * dx + Math.cos(turn) * dy];
}

/** Return the pixel of a tool target (m) in a picture that was taken at `pose`: the inverse of `target`. */
export function pixel(map: Map2, pose: number[], to: readonly [number, number], w: number, h: number): [number, number] {
  const [[a = 1, b = 0, c = 0] = [], [d = 0, e = 1, f = 0] = []] = map.matrix;
  const det = a * e - b * d;
  if (Math.abs(det) < 1e-12) return [(w - 1) / 2, (h - 1) / 2];
  const turn = (pose[3] ?? 0) - map.theta;
  const [x, y] = [to[0] - (pose[0] ?? 0), to[1] - (pose[1] ?? 0)];
  const dx = Math.cos(turn) * x + Math.sin(turn) * y - c,
    dy = Math.cos(turn) * y - Math.sin(turn) * x - f;
  return [(w - 1) / 2 + (e * dx - b * dy) / det, (h - 1) / 2 + (a * dy - d * dx) / det];
}

/** Return the pixel that is under the nozzle: where the map sends no motion. */
export function nozzlePixel(map: Map2, w: number, h: number): [number, number] {
  return pixel(map, [], [0, 0], w, h);
}
