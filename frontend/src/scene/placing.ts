/** Where an object may be put down, and the step of a task that puts it there. Lengths in m unless a name says mm. */
import type { Pose } from "../motion/chain.ts";
import { PLATE, type TaskStep } from "../widgets/task_text.ts";
import type { KnownObject, ObjectFacts, PlateFacts } from "./known.ts";
import { inverse, product, uprightAt } from "./poses.ts";

const UPRIGHT = 0.999; // the cosine of how far an object may lean that is put down by a step
const TOUCH = 0.0025; // between a surface and what counts as lying on it
const SQUARE = 0.02; // rad that a turn onto studs may differ from quarters
const ON_STUD = 0.0015; // of a place of the studs, for a step that names it
const QUARTER = Math.PI / 2;

/** What lies about. */
export interface Around {
  plate: PlateFacts | null;
  table: number; // height of the table
  lying: readonly KnownObject[];
}

export function topOf(plate: PlateFacts): number {
  return plate.place[2] + plate.thick;
}

export function yawOf(pose: Pose): number {
  return Math.atan2(pose[4]!, pose[0]!);
}

export function isUpright(pose: Pose): boolean {
  return pose[10]! > UPRIGHT;
}

/** Return an angle (rad) without turns after which an object looks the same, from zero on. */
function plain(angle: number, turns: number): number {
  const period = (2 * Math.PI) / turns,
    rest = ((angle % period) + period) % period;
  return period - rest < 1e-3 ? 0 : rest;
}

/** Return the place on the studs that is nearest to an object at a pose: column and row under its corner, and its pose there. */
export function nearestStud(
  plate: PlateFacts,
  facts: ObjectFacts,
  pose: Pose,
): { stud: [number, number]; turned: number; at: Float64Array } | null {
  if (!isUpright(pose)) return null;
  const quarters = Math.round(yawOf(pose) / QUARTER),
    [x, y] = quarters % 2 ? [facts.size[1], facts.size[0]] : [facts.size[0], facts.size[1]],
    corner = plate.studs.map((count, i) => plate.place[i]! - (count * plate.pitch) / 2);
  const stud = [x, y].map((wide, i) => 1 + Math.round((pose[i ? 7 : 3]! - wide / 2 - corner[i]!) / plate.pitch)) as [number, number];
  const fits = stud.every((n, i) => n >= 1 && (n - 1) * plate.pitch + [x, y][i]! <= plate.studs[i]! * plate.pitch + 1e-6);
  if (!fits) return null;
  const [u, v] = [x, y].map((wide, i) => corner[i]! + (stud[i]! - 1) * plate.pitch + wide / 2);
  const at = uprightAt([u!, v!, topOf(plate) + facts.size[2] / 2], quarters * QUARTER);
  return { stud, turned: (plain(quarters * QUARTER, facts.turns) * 180) / Math.PI, at };
}

/** Return the step that puts an object where its pose is; null where nothing is beneath it. */
export function stepFor(facts: ObjectFacts, pose: Pose, { plate, table, lying }: Around): TaskStep | null {
  if (!isUpright(pose)) return null;
  const bottom = pose[11]! - facts.size[2] / 2,
    touches = (top: number): boolean => Math.abs(bottom - top) <= TOUCH;
  const below = lying
    .filter((one) => isUpright(one.pose) && touches(one.pose[11]! + one.facts.size[2] / 2))
    .map((one) => ({ one, ...aside(one, pose) }))
    .filter(({ one, by }) => by.every((far, i) => Math.abs(far) < one.facts.size[i]! / 2 + facts.size[0] / 2))
    .sort((a, b) => Math.hypot(...a.by) - Math.hypot(...b.by))[0];
  if (below) return onto(facts, below.one.facts.name, below.by, below.turned);
  if (plate && isOver(plate, pose) && touches(topOf(plate))) {
    const near = nearestStud(plate, facts, pose),
      square = Math.abs(yawOf(pose) - Math.round(yawOf(pose) / QUARTER) * QUARTER) < SQUARE;
    if (near && square && Math.hypot(near.at[3]! - pose[3]!, near.at[7]! - pose[7]!) < ON_STUD)
      return { do: "on", name: facts.name, on: PLATE, stud: near.stud, ...(near.turned ? { turned: near.turned } : {}) };
    return null; // beside the places of the studs it would not hold
  }
  if (!touches(table)) return null;
  const yaw = (plain(yawOf(pose), facts.turns) * 180) / Math.PI;
  return { do: "at", name: facts.name, at: [mm(pose[3]!), mm(pose[7]!)], yaw: tenths(yaw) };
}

function isOver({ place, studs, pitch }: PlateFacts, pose: Pose): boolean {
  return studs.every((count, i) => Math.abs(pose[i ? 7 : 3]! - place[i]!) < (count * pitch) / 2);
}

/** Return how far a pose is from the middle of an object in its frame, and how it is turned from it (rad). */
function aside({ pose: base }: KnownObject, pose: Pose): { by: [number, number]; turned: number } {
  const between = product(
    inverse(base),
    Float64Array.from({ length: 16 }, (_, i) => pose[i]!),
  );
  return { by: [between[3]!, between[7]!], turned: yawOf(between) };
}

function onto(facts: ObjectFacts, on: string, by: readonly number[], turn: number): TaskStep {
  const moved = by.map(mm),
    turned = tenths((plain(turn, facts.turns) * 180) / Math.PI);
  return { do: "on", name: facts.name, on, ...(moved.some(Boolean) ? { by: moved } : {}), ...(turned ? { turned } : {}) };
}

function mm(metres: number): number {
  return tenths(metres * 1000);
}

function tenths(value: number): number {
  return Math.round(value * 10) / 10 || 0;
}
