/** What a mission would do, and remarks on it, as in ways.py and missions.py, so that both work without a connection. */
import type { Judgement } from "/static/farhand/v1/console.js";
import type { Case, Exhibit, Node } from "./hall_map.ts";
import { lineOf, type Step } from "./mission_text.ts";

export interface Hall {
  width: number;
  depth: number;
  case: readonly Case[];
  exhibit: readonly Exhibit[];
  node: readonly Node[];
}
/** The tables `mission` and `motion` of robot.toml. */
export interface Judged {
  hall: Hall;
  mission: { limit_s: number; room: number; speed: number; turn: number; settle_s: number; picture_s: number; look_s: number };
  motion: { most_speed: number; turn: number };
}
export type Pose = readonly [number, number, number];
/** The motion of a step: the poses at its corners (m, rad), its usual and its least duration (s). */
export interface Leg {
  step: number;
  poses: Pose[];
  seconds: number;
  least: number;
}
type Place = readonly [number, number];

const CORNER_M = 0.001; // the length that a corner adds
const ASIDE_M = 0.05,
  ASIDE_STEPS = 24,
  DIRECTIONS = 24; // steps away from something that is too near, and around the rover
const STEP_M = 0.05; // between two points of a line whose room is looked at
const CANNOT_STAND = "The rover cannot stand there: a wall, a showcase or an exhibit is too near.";
const CORNERED = "No way leads out of where the rover seems to be: let it look around, or drive it by hand.";
const NO_WAY = "No way leads there.";
const CLEAR_RAD = 2; // between two poses of a turn: less than half a turn, so that its direction is clear
const ROAMED = "its way is judged from where the patrol before it began, because nobody knows where that will end.";

export function remainder(angle: number): number {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}

/** Return the distance to the nearest surface (m); 0 inside of one or outside the hall. */
export function room(hall: Hall, [x, y]: Place): number {
  let least = Math.max(0, Math.min(x, hall.width - x, y, hall.depth - y));
  for (const { at, half } of hall.case)
    least = Math.min(least, Math.hypot(Math.max(Math.abs(x - at[0]) - half[0], 0), Math.max(Math.abs(y - at[1]) - half[1], 0)));
  for (const { at, radius } of hall.exhibit) least = Math.min(least, Math.max(Math.hypot(x - at[0], y - at[1]) - radius, 0));
  return least;
}

function isFree(d: Judged, [ax, ay]: Place, [bx, by]: Place): boolean {
  const count = Math.max(1, Math.ceil(Math.hypot(bx - ax, by - ay) / STEP_M));
  for (let n = 0; n <= count; n++)
    if (room(d.hall, [ax + ((bx - ax) * n) / count, ay + ((by - ay) * n) / count]) < d.mission.room) return false;
  return true;
}

/** Return the nearest place with room on whose straight way the rover comes no nearer to anything than it stands. */
function aside(d: Judged, [x, y]: Place): Place | undefined {
  const least = room(d.hall, [x, y]) - 1e-9;
  let angles = Array.from({ length: DIRECTIONS }, (_, direction) => (2 * Math.PI * direction) / DIRECTIONS);
  for (let number = 1; number <= ASIDE_STEPS; number++) {
    const free: number[] = [],
      away = ASIDE_M * number;
    for (const angle of angles) {
      const place: Place = [x + away * Math.cos(angle), y + away * Math.sin(angle)],
        left = room(d.hall, place);
      if (left >= d.mission.room) return place;
      if (left >= least) free.push(angle);
    }
    angles = free;
  }
  return undefined;
}

/** Return the shortest way over the nodes, without its begin; a sentence if there is none. */
function wayTo(d: Judged, begin: Place, end: Place): Place[] | string {
  if (!(room(d.hall, end) >= d.mission.room)) return CANNOT_STAND;
  if (!(room(d.hall, begin) >= d.mission.room)) {
    const first = aside(d, begin),
      rest = first && wayTo(d, first, end);
    return typeof rest === "object" ? [first!, ...rest] : (rest ?? CORNERED);
  }
  if (isFree(d, begin, end)) return [end];
  const nodes = d.hall.node,
    named = new Map(nodes.map(({ name }, i) => [name, i]));
  const apart = ([ax, ay]: Place, [bx, by]: Place): number => Math.hypot(ax - bx, ay - by) + CORNER_M;
  const reached = nodes.flatMap(({ at }, i) => (isFree(d, begin, at) ? [i] : []));
  const cost = nodes.map(() => Infinity),
    before = nodes.map(() => -1),
    open = new Set(nodes.keys());
  for (const i of reached) cost[i] = apart(begin, nodes[i]!.at);
  while (open.size) {
    const here = [...open].reduce((best, i) => (cost[i]! < cost[best]! ? i : best));
    open.delete(here);
    for (const name of nodes[here]!.to) {
      const next = named.get(name)!,
        there = cost[here]! + apart(nodes[here]!.at, nodes[next]!.at);
      if (there < cost[next]!) [cost[next], before[next]] = [there, here];
    }
  }
  const last = nodes.flatMap(({ at }, i) => (cost[i]! < Infinity && isFree(d, at, end) ? [[i, cost[i]! + apart(at, end)] as const] : []));
  if (!last.length) return NO_WAY;
  const found: Place[] = [end];
  for (let at = last.reduce((best, one) => (one[1] < best[1] ? one : best))[0]; at >= 0; at = before[at]!) found.push(nodes[at]!.at);
  return found.reverse();
}

/** Return what each step does, beginning at `here`, as far as the mission can run, and all remarks on it. */
export function judge(d: Judged, steps: readonly Step[], here: Pose): { legs: Leg[]; said: Judgement[] } {
  const legs: Leg[] = [],
    said: Judgement[] = [];
  const minutes = d.mission.limit_s / 60;
  let usual = 0,
    least = 0,
    late = false,
    roams = false;
  for (const [i, step] of steps.entries()) {
    const number = i + 1,
      leg = legOf(d, step, number, here);
    if (typeof leg === "string")
      return { legs, said: [...said, { step: number, at_s: usual, text: `Step ${number}, ${lineOf(step)}: ${leg}`, refuses: true }] };
    if (roams && step.do === "go") {
      said.push({ step: number, at_s: usual, text: `Step ${number}, ${lineOf(step)}: ${ROAMED}`, refuses: false });
      roams = false;
    }
    roams ||= step.do === "patrol";
    usual += leg.seconds;
    least += leg.least;
    if (least > d.mission.limit_s) {
      const text = `Step ${number} cannot be done in time: even without a pause the mission would last longer than ${minutes} minutes there. Leave steps out.`;
      return { legs, said: [...said, { step: number, at_s: usual, text, refuses: true }] };
    }
    if (usual > d.mission.limit_s && !late) {
      late = true;
      said.push({
        step: number,
        at_s: usual,
        text: `Step ${number} may not be done in time: as a rule the mission lasts longer than ${minutes} minutes there.`,
        refuses: false,
      });
    }
    legs.push(leg);
    here = leg.poses.at(-1)!;
  }
  return { legs, said };
}

/** Return the poses of a turn in place (rad, to the left), without the first. */
function turned([x, y, heading]: Pose, angle: number): Pose[] {
  const count = Math.max(1, Math.ceil(Math.abs(angle) / CLEAR_RAD));
  return Array.from({ length: count }, (_, n): Pose => [x, y, remainder(heading + (angle * (n + 1)) / count)]);
}

function legOf(d: Judged, step: Step, number: number, begin: Pose): Leg | string {
  const { mission, motion } = d,
    poses: Pose[] = [begin];
  let here = begin,
    seconds = 0,
    least = 0;
  if (step.do === "go") {
    const corners = wayTo(d, [here[0], here[1]], [step.x, step.y]);
    if (typeof corners === "string") return corners;
    for (const [x, y] of corners) {
      const away = Math.hypot(x - here[0], y - here[1]),
        heading = away > 1e-6 ? Math.atan2(y - here[1], x - here[0]) : here[2];
      const turn = Math.abs(remainder(heading - here[2]));
      here = [x, y, heading];
      poses.push(here);
      seconds += away / mission.speed + turn / mission.turn + mission.settle_s;
      least += away / motion.most_speed + turn / motion.turn;
    }
  } else if (step.do === "turn") {
    const angle = (step.degrees * Math.PI) / 180;
    poses.push(...turned(here, angle));
    seconds = Math.abs(angle) / mission.turn + mission.settle_s;
    least = Math.abs(angle) / motion.turn;
  } else if (step.do === "wait" || step.do === "patrol") seconds = least = step.seconds;
  else if (step.do === "look") {
    poses.push(...turned(here, 2 * Math.PI));
    [seconds, least] = [mission.look_s, (2 * Math.PI) / motion.turn];
  } else if (step.do === "photograph") seconds = mission.picture_s;
  return { step: number, poses, seconds, least };
}
