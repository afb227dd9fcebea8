/** The directions that a gamepad's sticks give, and which gamepads count. */
import { gettext } from "../kit/text.ts";

export type Direction = readonly [number, number];
/** What is read of a gamepad. */
export type Pad = Pick<Gamepad, "axes" | "buttons" | "connected"> & Partial<Pick<Gamepad, "id" | "index" | "mapping">>;

const STICK = 0.5;
const REST = 0.3; // an axis this near to zero is at rest
const LEFT_STICK = 2; // its axes are the first ones of every gamepad; what follows differs, and triggers rest at -1
const RELEASE = gettext("Gamepad: release its sticks and buttons first.");
const UNKNOWN = gettext("Gamepad: this browser does not know its layout, so only the left stick counts.");

/** Return the gamepads of this browser; none where it has none or does not let this page read them. */
function gamepads(): (Pad | null)[] {
  try {
    return "getGamepads" in navigator ? [...navigator.getGamepads()] : [];
  } catch {
    return [];
  }
}

/** Which parts of gamepads count: those that were seen at rest since the gamepad was connected, or since `forget`. */
export class Pads {
  /** Why a gamepad does less than somebody may expect; empty if it does all. */
  why = "";
  private seen = new Map<number, { what: string; rested: Set<string> }>();

  /** Forget all gamepads: each has to be seen at rest again. */
  forget(): void {
    this.seen.clear();
  }

  /** Return what the first gamepad asks for that is not at rest; null for none, and while nobody sees the control. */
  wanted<T>(control: HTMLElement, read: (pad: Pad) => T | null): T | null {
    const away = document.hidden || control.closest("[hidden]") !== null;
    if (away) this.forget();
    const wishes = this.read(away ? [] : gamepads()).map(read);
    return wishes.find((wish) => wish !== null) ?? null;
  }

  /** Return the gamepads as they count now: other axes are at rest, other buttons are not pressed. */
  read(pads: readonly (Pad | null)[]): Pad[] {
    this.why = "";
    const here = pads.flatMap((pad, i) => (pad?.connected ? [{ pad, place: pad.index ?? i }] : []));
    for (const place of this.seen.keys()) if (!here.some((one) => one.place === place)) this.seen.delete(place);
    return here.map(({ pad, place }) => this.counted(pad, place));
  }

  private counted(pad: Pad, place: number): Pad {
    const known = pad.mapping === "standard";
    const what = `${pad.id} ${pad.mapping} ${pad.axes.length} ${pad.buttons.length}`;
    const before = this.seen.get(place);
    const rested = before?.what === what ? before.rested : new Set<string>();
    this.seen.set(place, { what, rested });
    const held: string[] = []; // since before it was connected
    const counts = (name: string, atRest: boolean): boolean => {
      if (atRest) rested.add(name);
      if (!rested.has(name)) held.push(name);
      return rested.has(name);
    };
    const axes = pad.axes.map((v, i) => ((known || i < LEFT_STICK) && counts(`axis ${i}`, Math.abs(v) < REST) ? v : 0));
    const buttons = known
      ? pad.buttons.map((b, i) => (counts(`button ${i}`, !b.pressed) ? b : { pressed: false, touched: b.touched, value: 0 }))
      : [];
    this.why ||= held.length ? RELEASE : known ? "" : UNKNOWN;
    return { axes, buttons, connected: true };
  }
}

/** The direction of a gamepad's left stick or cross; null at rest. Up is away from the robot. */
export function stick(pad: Pad | null): Direction | null {
  if (!pad?.connected) return null;
  const down = (i: number): number => (pad.buttons[i]?.pressed ? 1 : 0);
  const x = (pad.axes[0] ?? 0) + down(15) - down(14);
  const y = down(12) - down(13) - (pad.axes[1] ?? 0);
  return Math.hypot(x, y) < STICK ? null : [Math.max(-1, Math.min(1, x)), Math.max(-1, Math.min(1, y))];
}

/** How a gamepad's two sticks would move a tool; null at rest. Up on the left stick is away from the base. */
export function twist(pad: Pad | null): Record<string, number> | null {
  if (!pad?.connected) return null;
  const pull = (i: number): number => {
    const v = pad.axes[i] ?? 0;
    return Math.abs(v) < STICK ? 0 : Math.max(-1, Math.min(1, -v));
  };
  const way = { x: pull(1), y: pull(0), z: pull(3), yaw: pull(2) };
  const felt = Object.entries(way).filter(([, v]) => v !== 0);
  return felt.length ? Object.fromEntries(felt) : null;
}
