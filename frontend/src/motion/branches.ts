/**
 * All branches of the inverse kinematics in closed form, of an arm with six axes whose last three meet in one point (a
 * spherical wrist) and whose second and third are parallel: the place of the wrist's centre gives the first three
 * angles, the rotation that is left the last three (Pieper 1968). The subproblems are chosen as in Elias and Wen 2025,
 * section 4 ("spherical joint and two parallel axes"), which EAIK follows, too, so that both sides answer targets out of
 * reach alike.
 */
import { type Chain, FRAME, type Pose } from "./chain.ts";
import { ontoPlane, ontoPoint, ontoSphere } from "./subproblems.ts";
import { cross, dot, minus, norm, plus, times, turned, type Vec3 } from "./vectors.ts";

const MEET_M = 1e-7; // axes that pass each other by less than this meet
const PARALLEL = 1e-9;

export class Branches {
  private readonly axes: Vec3[] = []; // of the joints at zero
  private readonly first: Vec3; // from the base to a point of the first axis,
  private readonly second: Vec3; // from there to one of the second,
  private readonly third: Vec3; // to one of the third,
  private readonly wrist: Vec3; // to the wrist's centre,
  private readonly tip: Vec3; // to the tool
  private readonly upright: Pose; // the tool's pose with all joints at zero

  /** Throw an Error if the arm has another shape. */
  constructor(chain: Chain) {
    const frames = chain.frames(new Float64Array(chain.count)),
      points: Vec3[] = [];
    for (const [n, { axis }] of chain.joints.entries()) {
      const [x = 0, y = 0, z = 0] = axis;
      this.axes.push(rotated(frames.subarray(FRAME * n), [x, y, z]));
      points.push(place(frames.subarray(FRAME * n)));
    }
    const [, h2, h3, h4, h5] = this.axes,
      [o1, o2, o3, o4, o5, o6] = points;
    if (!h2 || !h3 || !h4 || !h5 || !o1 || !o2 || !o3 || !o4 || !o5 || !o6) throw new Error("the arm has fewer than six axes");
    const centre = meeting(o4, h4, o5, h5);
    if (chain.count !== 6 || norm(cross(h2, h3)) > PARALLEL || !centre || offAxis(centre, o6, this.axes[5]!) > MEET_M)
      throw new Error("no closed form is known for an arm of this shape");
    const shoulder = meeting(o1, this.axes[0]!, o2, h2); // least squares depend on where on its axis a point lies
    this.first = shoulder ?? o1;
    this.second = minus(shoulder ?? o2, this.first);
    this.third = minus(o3, shoulder ?? o2);
    this.wrist = minus(centre, o3);
    this.upright = frames.slice(FRAME * 6);
    this.tip = minus(place(this.upright), centre);
  }

  /** Return the branches, at most eight, for a pose of the tool: six angles each (rad, any turn), out of reach of least squares. */
  of(pose: Pose): number[][] {
    const [h1, h2, h3] = this.axes as [Vec3, Vec3, Vec3],
      { first, second, third, wrist } = this;
    const centre = minus(minus(place(pose), first), this.rotated(pose, this.tip)); // of the wrist, from the first axis
    const base = ontoPlane(times(h1, -1), centre, h2, dot(h2, plus(plus(second, third), wrist)));
    return base.flatMap((q1) => {
      const there = minus(turned(h1, -q1, centre), second);
      return ontoSphere(h3, times(wrist, -1), third, norm(there)).flatMap((q3) => {
        const q2 = ontoPoint(h2, plus(third, turned(h3, q3, wrist)), there);
        return this.ends(pose, q1, q2, q3);
      });
    });
  }

  /** Return the branches with these first three angles: one or two of the wrist. */
  private ends(pose: Pose, q1: number, q2: number, q3: number): number[][] {
    const [h1, h2, h3, h4, h5, h6] = this.axes as [Vec3, Vec3, Vec3, Vec3, Vec3, Vec3];
    // the sixth axis as the forearm shall see it, and the fourth as the tool shall
    const sixth = turned(h3, -q3, turned(h2, -q2, turned(h1, -q1, this.rotated(pose, h6))));
    const fourth = this.seen(pose, turned(h1, q1, turned(h2, q2, turned(h3, q3, h4))));
    return ontoPlane(h5, h6, h4, dot(h4, sixth)).map((q5) => {
      const q4 = ontoPoint(h4, turned(h5, q5, h6), sixth),
        q6 = ontoPoint(times(h6, -1), turned(h5, -q5, h4), fourth);
      return [q1, q2, q3, q4, q5, q6];
    });
  }

  /** Return a vector of the arm at zero, turned with the tool from there to `pose`. */
  private rotated(pose: Pose, v: Vec3): Vec3 {
    return rotated(pose, back(this.upright, v));
  }

  /** Return the vector that the tool would carry into `v` on its way from the arm at zero to `pose`. */
  private seen(pose: Pose, v: Vec3): Vec3 {
    return rotated(this.upright, back(pose, v));
  }
}

const place = (pose: Pose): Vec3 => [pose[3]!, pose[7]!, pose[11]!];
const row = (pose: Pose, n: number): Vec3 => [pose[4 * n]!, pose[4 * n + 1]!, pose[4 * n + 2]!];
const rotated = (pose: Pose, v: Vec3): Vec3 => [dot(row(pose, 0), v), dot(row(pose, 1), v), dot(row(pose, 2), v)];
const back = (pose: Pose, v: Vec3): Vec3 => plus(plus(times(row(pose, 0), v[0]), times(row(pose, 1), v[1])), times(row(pose, 2), v[2]));

/** Return where two lines meet (a point and a unit vector each); null if they are parallel or pass each other. */
function meeting(p: Vec3, h: Vec3, q: Vec3, k: Vec3): Vec3 | null {
  const normal = cross(h, k),
    size = dot(normal, normal),
    gap = minus(q, p);
  if (size < PARALLEL || Math.abs(dot(normal, gap)) / Math.sqrt(size) > MEET_M) return null;
  return plus(p, times(h, dot(cross(gap, k), normal) / size));
}

function offAxis(point: Vec3, on: Vec3, axis: Vec3): number {
  return norm(cross(axis, minus(point, on)));
}
