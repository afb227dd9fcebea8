/**
 * A pad for fingers, also on a phone that serves as a controller: one finger moves along the table (up on the pad is away
 * from the base), two fingers move up and down and turn about the upright axis. If the phone's turns count, they turn the
 * tool while a finger is on the pad.
 */
import { product, type Quaternion, type Rigid, turnedBy } from "../motion/rigid.ts";
import { Clutch } from "./clutch.ts";
import { moveOf, type Reading, type Source } from "./source.ts";
import { gettext } from "../kit/text.ts";

const M_PER_PX = 0.0005;
const TILT_S = 0.06; // time constant of the filter: a hand trembles
const LEVEL: Quaternion = [0, 0, 0, 1];
type Point = readonly [number, number];

/** Return the turn of a second finger about a first, rad. */
function angle([a, b]: readonly Point[]): number {
  return a && b ? Math.atan2(b[1] - a[1], b[0] - a[0]) : 0;
}

/** Return where the hand is by its fingers (px; y down) that are on the pad, from where they came down. */
export function handOf(begin: readonly Point[], now: readonly Point[], tilt: Quaternion = LEVEL): Rigid {
  const mean = (points: readonly Point[], axis: 0 | 1): number => points.reduce((sum, p) => sum + p[axis], 0) / Math.max(1, points.length);
  const right = (mean(now, 0) - mean(begin, 0)) * M_PER_PX,
    up = (mean(begin, 1) - mean(now, 1)) * M_PER_PX,
    isTwo = now.length > 1;
  const spun = isTwo ? angle(begin) - angle(now) : 0, // y is down, so a turn to the left is negative there
    turn = turnedBy(tilt, [0, 0, Math.atan2(Math.sin(spun), Math.cos(spun))]);
  return { at: isTwo ? [0, -right, up] : [up, -right, 0], turn };
}

/**
 * Return how a phone has turned since `begin`, about the axes of the arm's base: its upper edge (or its back, where it is
 * held upright) then pointed away from the base. Both are turns from the ground to the phone.
 */
export function turnSince(begin: Quaternion, now: Quaternion): Quaternion {
  const back: Quaternion = [-begin[0], -begin[1], -begin[2], begin[3]],
    [x, y, z, w] = product(now, back), // about the axes of the ground
    edge = pointing(begin, [0, 1, 0]),
    ahead = Math.hypot(edge[0], edge[1]) > 0.5 ? edge : pointing(begin, [0, 0, -1]),
    heading = Math.atan2(ahead[1], ahead[0]),
    c = Math.cos(heading),
    s = Math.sin(heading);
  return [c * x + s * y, c * y - s * x, z, w];
}

function pointing(turn: Quaternion, [x, y, z]: readonly [number, number, number]): Quaternion {
  return product(product(turn, [x, y, z, 0]), [-turn[0], -turn[1], -turn[2], turn[3]]);
}

/** Return the turn from the ground to a phone, by the angles of a `deviceorientation` event (degrees); null for none. */
export function orientation(alpha: number | null, beta: number | null, gamma: number | null): Quaternion | null {
  if (alpha === null || beta === null || gamma === null || ![alpha, beta, gamma].every(Number.isFinite)) return null;
  const about = (axis: number, degrees: number): Quaternion => {
    const half = (degrees * Math.PI) / 360,
      turn = [0, 0, 0, Math.cos(half)];
    turn[axis] = Math.sin(half);
    return turn as unknown as Quaternion;
  };
  return product(product(about(2, alpha), about(0, beta)), about(1, gamma)); // Z, X', Y'': W3C Device Orientation
}

/** Feels the phone's turns, once somebody has asked for it; some browsers ask the person, and only after a press. */
export class Tilt {
  now: Quaternion | null = null;
  private on = false;
  private readonly listen = ({ alpha, beta, gamma }: DeviceOrientationEvent): void => void (this.now = orientation(alpha, beta, gamma));

  /** Begin or end. Returns why it does not work; empty if it does. */
  async use(on: boolean): Promise<string> {
    this.now = null;
    if (on === this.on) return "";
    if (!on) removeEventListener("deviceorientation", this.listen);
    else if (!("DeviceOrientationEvent" in globalThis)) return gettext("This device does not tell how it is turned.");
    else {
      const asking = DeviceOrientationEvent as unknown as { requestPermission?: () => Promise<string> };
      const answer = await asking.requestPermission?.().catch(() => "denied");
      if (answer !== undefined && answer !== "granted") return gettext("The browser does not let this page feel how the phone is turned.");
      addEventListener("deviceorientation", this.listen);
    }
    this.on = on;
    return "";
  }
}

export class TouchSource implements Source {
  readonly name = "touch pad";
  readonly isRate = false;
  private fingers = new Map<number, Point>();
  private begin: Point[] = [];
  private turned: Quaternion | null = null; // the phone, when the fingers came down
  private clutch = new Clutch({ smooth_s: TILT_S });
  private readonly tilt: Tilt;

  constructor(pad: HTMLElement, tilt: Tilt, changed: () => void) {
    this.tilt = tilt;
    pad.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || this.fingers.size > 1) return;
      event.preventDefault();
      pad.setPointerCapture(event.pointerId);
      this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
      this.take();
    });
    pad.addEventListener("pointermove", ({ pointerId, clientX, clientY }) => {
      if (this.fingers.has(pointerId)) this.fingers.set(pointerId, [clientX, clientY]);
    });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"] as const)
      pad.addEventListener(name, ({ pointerId }) => {
        if (!this.fingers.delete(pointerId)) return;
        this.take();
        changed();
      });
  }

  /** Take the hand afresh: a finger more or less makes no jump. */
  private take(): void {
    this.begin = [...this.fingers.values()];
    this.turned = this.tilt.now;
    if (this.begin.length) this.clutch.engage(this.hand());
    else this.clutch.release();
  }

  private hand(): Rigid {
    const { now } = this.tilt;
    this.turned ??= now; // a phone may tell it for the first time while a finger is down
    const tilted = this.turned && now ? turnSince(this.turned, now) : LEVEL;
    return handOf(this.begin, [...this.fingers.values()], tilted);
  }

  read(elapsed_s: number): Reading | null {
    const change = this.clutch.move(this.hand(), elapsed_s);
    if (!change) {
      this.forget(); // it jumped
      return null;
    }
    return { by: moveOf(change), clutch: true, grip: "" };
  }

  forget(): void {
    this.fingers.clear();
    this.clutch.release();
  }
}
