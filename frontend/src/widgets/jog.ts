/** A held motion: it goes on while the controls are held, and ends when they are released or the page cannot tell. */
import { say } from "../kit/dom.ts";
import { allow } from "../kit/refusal.ts";
import type { KeepAlive } from "../socket/held_motion.ts";
import { type Pad, Pads } from "./gamepad.ts";

export interface JogSettings<Direction> extends KeepAlive {
  /** The direction that a control's `data-jog` names. */
  read(words: string): Direction;
  /** Keys that jog while the pad has the focus. */
  arrows?: Record<string, Direction>;
  /** What a gamepad asks for; null at rest. */
  stick?(pad: Pad | null): Direction | null;
  /** Why no motion may start now; empty if one may. */
  whyNot(): string;
  /** Issue the command; returns its sequence number. */
  begin(direction: Direction): number;
}

/** Return `name,way` as the one value that a control moves. */
export function named(words: string): Record<string, number> {
  const [name = "", way = "0"] = words.split(",");
  return { [name]: Number(way) };
}

export const KEEP_MS = 80;

/** Call `down` when a pointer presses the control, which gets the focus, and `up` when the pointer is released or lost. */
export function onPress(control: HTMLElement, down: (event: PointerEvent) => void, up: () => void): void {
  control.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    control.focus({ preventScroll: true });
    try {
      control.setPointerCapture(event.pointerId);
    } catch {
      return; // it was released already
    }
    down(event);
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) control.addEventListener(name, up);
  control.addEventListener("contextmenu", (event) => event.preventDefault());
}

export class Jog<Direction> {
  private seq = 0;
  private by: "pointer" | "key" | "pad" | "" = "";
  private timer = 0;
  private last = 0;
  private pads = new Pads();
  private hint: HTMLElement | null;
  private advice: string; // the text of the hint in the template

  constructor(
    private pad: HTMLElement,
    private jogging: JogSettings<Direction>,
  ) {
    this.hint = pad.querySelector(".hint");
    this.hint?.setAttribute("role", "status");
    this.advice = this.hint?.textContent ?? "";
    for (const button of pad.querySelectorAll<HTMLElement>("[data-jog]")) {
      const begin = (): void => this.begin(jogging.read(button.dataset["jog"] ?? ""), "pointer");
      onPress(button, begin, () => this.end("pointer"));
    }
    pad.addEventListener("keydown", (event) => this.keyDown(event));
    pad.addEventListener("keyup", () => this.end("key"));
    pad.addEventListener("focusout", () => this.end("key"));
    addEventListener("blur", () => this.end());
    addEventListener("pagehide", () => this.end());
    document.addEventListener("visibilitychange", () => document.hidden && this.end());
    setInterval(() => this.feelPad(), 40);
  }

  /** Enable the controls, or disable them with a reason; a motion that is held goes on. */
  enable(why: string): void {
    for (const control of this.pad.querySelectorAll<HTMLElement>("[data-jog]")) allow(control, this.seq ? "" : why);
  }

  private keyDown(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const own = (event.target as HTMLElement).dataset["jog"];
    const pressed = event.key === " " || event.key === "Enter";
    const direction = pressed && own ? this.jogging.read(own) : this.jogging.arrows?.[event.key];
    if (direction === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    if (!event.repeat) this.begin(direction, "key");
  }

  private feelPad(): void {
    const direction = this.pads.wanted(this.pad, (pad) => this.jogging.stick?.(pad) ?? null);
    if (this.hint) say(this.hint, this.pads.why || this.advice); // its place is as high as the longest of these
    if (this.by === "pad" && !direction) this.end("pad");
    else if (direction && !this.seq && document.hasFocus() && performance.now() - this.last > 250) this.begin(direction, "pad");
  }

  private begin(direction: Direction, by: "pointer" | "key" | "pad"): void {
    if (this.seq) return;
    this.last = performance.now();
    const why = this.jogging.whyNot();
    if (why && by === "pad") this.pads.forget(); // a stick that stays pushed begins nothing later
    if (why) return this.jogging.refused(why, () => this.jogging.whyNot());
    this.by = by;
    this.seq = this.jogging.begin(direction);
    this.pad.classList.add("held");
    this.timer = window.setInterval(() => {
      if (this.jogging.ended(this.seq)) this.end();
      else this.jogging.keep(this.seq);
    }, KEEP_MS);
  }

  /** End the motion; with `by`, only one that was started that way. */
  end(by = this.by): void {
    if (!this.seq || by !== this.by) return;
    clearInterval(this.timer);
    if (by === "pad") this.pads.forget();
    this.jogging.release(this.seq);
    this.seq = 0;
    this.by = "";
    this.last = performance.now();
    this.pad.classList.remove("held");
  }
}
