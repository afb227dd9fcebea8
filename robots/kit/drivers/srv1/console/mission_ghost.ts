/** The place of a mission's ghost: it turns in place, then drives, as the rover does. */
import { type Judged, type Leg, type Pose, remainder } from "./mission_judge.ts";

/** Return the ghost's pose so many seconds after the begin; null once the mission has ended. */
export function ghostAt(d: Judged, legs: readonly Leg[], seconds: number): Pose | null {
  for (const { poses, seconds: lasts } of legs) {
    if (seconds < lasts) return along(d, poses, seconds / lasts);
    seconds -= lasts;
  }
  return null;
}

/** Return the pose after a share of the time that a path through `poses` takes. */
function along({ mission }: Judged, poses: readonly Pose[], share: number): Pose {
  const parts = poses.slice(1).map((to, i) => {
    const from = poses[i]!,
      turn = remainder(to[2] - from[2]);
    return { from, to, turn, turns: Math.abs(turn) / mission.turn, drives: Math.hypot(to[0] - from[0], to[1] - from[1]) / mission.speed };
  });
  let left = share * parts.reduce((sum, { turns, drives }) => sum + turns + drives, 0);
  for (const { from, to, turn, turns, drives } of parts) {
    const [x, y, heading] = from;
    if (left < turns) return [x, y, remainder(heading + (turn * left) / turns)];
    left -= turns;
    if (left < drives) return [x + ((to[0] - x) * left) / drives, y + ((to[1] - y) * left) / drives, to[2]];
    left -= drives;
  }
  return poses.at(-1)!;
}
