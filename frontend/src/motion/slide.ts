/**
 * A ghost that stops at surfaces and slides along them: a god-object (Zilles and Salisbury 1995). The hand's wish goes
 * where it likes; the ghost goes as far as the planner allows, and the rest of the way is projected on what is allowed.
 */
import { between, type Change, moved, type Rigid } from "./rigid.ts";
import { dot, minus, norm, plus, times, type Vec3 } from "./vectors.ts";

const PIECE_M = 0.005; // the way is gone in pieces no longer than this, so that no thin box is passed over,
const PIECE_RAD = 0.05;
const PIECES = 24; // and no more of them at once
const HALVINGS = 5;
const RETREAT = 0.05; // of a piece: a surface that bends away is followed by so much
const AXES: readonly Vec3[] = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const NONE: Vec3 = [0, 0, 0];

/** Whether the ghost may be at a pose. */
export type Allowed = (pose: Rigid) => boolean;

/** Return where the ghost comes to on its way to `wanted`, and whether something stopped it. `centre` (m): of the arm's reach. */
export function slide(here: Rigid, wanted: Rigid, allowed: Allowed, centre: Vec3): { pose: Rigid; stopped: boolean } {
  const whole = between(here, wanted),
    count = Math.max(1, Math.ceil(Math.max(norm(whole.way) / PIECE_M, norm(whole.turn) / PIECE_RAD)));
  let pose = here,
    stopped = count > PIECES;
  for (let n = 0; n < Math.min(count, PIECES); n++) {
    const piece = { way: times(whole.way, 1 / count), turn: times(whole.turn, 1 / count) };
    if (allowed(moved(pose, piece))) {
      pose = moved(pose, piece);
      continue;
    }
    stopped = true;
    const share = farthest(pose, piece, allowed),
      here = moved(pose, piece, share);
    pose = beside(here, { way: times(piece.way, 1 - share), turn: times(piece.turn, 1 - share) }, allowed, centre);
    if (share === 0 && pose === here) break; // the other pieces are the same
  }
  return { pose, stopped };
}

/** Return the greatest share of a change that is allowed, by halving. */
function farthest(pose: Rigid, change: Change, allowed: Allowed): number {
  let low = 0,
    high = 1;
  for (let n = 0; n < HALVINGS; n++) {
    const middle = (low + high) / 2;
    if (allowed(moved(pose, change, middle))) low = middle;
    else high = middle;
  }
  return low;
}

/** Return the pose after the longest part of a change that is allowed: without what leads along a normal, or without the turn. */
function beside(pose: Rigid, { way, turn }: Change, allowed: Allowed, centre: Vec3): Rigid {
  const off = minus(pose.at, centre),
    normals = [...AXES, times(off, 1 / Math.max(norm(off), 1e-9))];
  const tangents = normals.flatMap((normal) => {
    const along = minus(way, times(normal, dot(way, normal))),
      back = times(normal, -RETREAT * norm(along));
    return [along, plus(along, back)];
  });
  const alone = AXES.map((axis) => times(axis, dot(way, axis)));
  const ways = [...tangents, ...alone].sort((a, b) => dot(b, way) - dot(a, way));
  const tried = [
    { way, turn: NONE },
    ...ways.flatMap((one) => [
      { way: one, turn },
      { way: one, turn: NONE },
    ]),
    { way: NONE, turn },
  ];
  const found = tried.find((change) => norm(change.way) + norm(change.turn) > 1e-9 && allowed(moved(pose, change)));
  return found ? moved(pose, found) : pose;
}
