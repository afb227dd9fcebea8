/** Where a click in a calibrated camera's picture is on the table, and where a place is in the picture. Lengths in m. */
import type { Pose } from "../motion/chain.ts";
import { cross, dot, minus, norm, plus, times, type Vec3 } from "../motion/vectors.ts";
import type { KnownObject, PlateFacts } from "./known.ts";
import { inverse } from "./poses.ts";
import { gettext, translate } from "../kit/text.ts";

/** A calibrated camera: the place of its lens and a point in the middle of its picture, its horizontal field of view. */
export interface Camera {
  name: string;
  place: number[];
  at: number[];
  field_deg: number;
}
/** A place that was chosen: on an object, on the plate, or on the table. `object`: its name, empty for none. */
export interface Place {
  at: Vec3;
  object: string;
}
/** What there is to be clicked on: objects, a plate with studs, how high the table is. */
export interface Around {
  known: readonly KnownObject[];
  plate: PlateFacts | null;
  table: number;
}

/** Return the camera's axes in the base's frame, right, down and forward, and its focal length in widths of the picture. */
function axes({ place, at, field_deg }: Camera): { right: Vec3; down: Vec3; forward: Vec3; focal: number } {
  const forward = unit(minus(three(at), three(place))),
    right = unit(cross(forward, [0, 0, 1]));
  return { right, down: cross(forward, right), forward, focal: 0.5 / Math.tan((field_deg * Math.PI) / 360) };
}

/** Return where a place is in the picture, as shares of its width and height (0 to 1); null behind the lens. */
export function inPicture(camera: Camera, place: Vec3, aspect: number): [number, number] | null {
  const { right, down, forward, focal } = axes(camera),
    from = minus(place, three(camera.place)),
    depth = dot(from, forward);
  if (depth <= 0) return null;
  return [0.5 + (focal * dot(from, right)) / depth, 0.5 + (focal * dot(from, down) * aspect) / depth];
}

/** Return what lies under a point of the picture (shares of width and height); null where that is no place to reach. */
export function placeAt(camera: Camera, [u, v]: readonly [number, number], aspect: number, around: Around): Place | null {
  const { right, down, forward, focal } = axes(camera),
    from = three(camera.place),
    across = (u - 0.5) / focal,
    below = (v - 0.5) / focal / aspect,
    way = unit(plus(forward, plus(times(right, across), times(down, below))));
  const hits = around.known
    .filter(({ held }) => !held)
    .map((one) => ({ one, far: boxAlong(one.pose, one.facts.size, from, way) }))
    .filter(({ far }) => far !== null)
    .sort((a, b) => a.far! - b.far!);
  const [first] = hits;
  if (first) return { at: topOf(first.one), object: first.one.facts.name };
  return onPlate(around.plate, from, way) ?? onLevel(around.table, from, way);
}

/** Return the middle of an object's top. */
export function topOf({ pose, facts }: KnownObject): Vec3 {
  const high = facts.size.reduce((sum, edge, i) => sum + (Math.abs(pose[8 + i]!) * edge) / 2, 0);
  return [pose[3]!, pose[7]!, pose[11]! + high];
}

function onPlate(plate: PlateFacts | null, from: Vec3, way: Vec3): Place | null {
  const found = plate && onLevel(plate.place[2] + plate.thick, from, way);
  const isOn = found && plate.studs.every((count, i) => Math.abs(found.at[i]! - plate.place[i]!) < (count * plate.pitch) / 2);
  return isOn ? found : null;
}

function onLevel(height: number, from: Vec3, way: Vec3): Place | null {
  const far = (height - from[2]) / way[2];
  return way[2] < 0 && far > 0 ? { at: plus(from, times(way, far)), object: "" } : null;
}

/** Return how far along a ray a box begins; null where the ray misses it. */
function boxAlong(pose: Pose, size: Vec3, from: Vec3, way: Vec3): number | null {
  const back = inverse(pose),
    local = (v: Vec3, moved: number): number[] =>
      [0, 4, 8].map((row) => back[row]! * v[0] + back[row + 1]! * v[1] + back[row + 2]! * v[2] + moved * back[row + 3]!);
  const start = local(from, 1),
    along = local(way, 0);
  let near = 0,
    far = Infinity;
  for (const [i, edge] of size.entries()) {
    if (Math.abs(along[i]!) < 1e-12) {
      if (Math.abs(start[i]!) > edge / 2) return null;
      continue;
    }
    const ends = [-edge / 2, edge / 2].map((end) => (end - start[i]!) / along[i]!);
    near = Math.max(near, Math.min(...ends));
    far = Math.min(far, Math.max(...ends));
  }
  return near <= far ? near : null;
}

/** Return a place in words, as people beside the arm would say it. */
export function placeInWords({ at: [x, y], object }: Place): string {
  const far = { mm: Math.abs(mm(x)) },
    aside = { mm: Math.abs(mm(y)) };
  const what = object ? gettext("The object {object}", { object: translate(object) }) : gettext("The table"),
    ahead = x < 0 ? gettext("{mm} mm behind the base", far) : gettext("{mm} mm ahead of the base", far),
    side = y > 0 ? gettext("{mm} mm to its left", aside) : gettext("{mm} mm to its right", aside);
  return [what, ahead, ...(aside.mm ? [side] : [])].join(", ");
}

function mm(metres: number): number {
  return Math.round(metres * 1000);
}

function three([x = 0, y = 0, z = 0]: readonly number[]): Vec3 {
  return [x, y, z];
}

function unit(a: Vec3): Vec3 {
  return times(a, 1 / norm(a));
}
