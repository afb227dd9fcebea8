/** A stick on the screen for a held motion that is steered: up is speed, to the side is steering. */
import { make } from "../kit/dom.ts";
import { allow } from "../kit/refusal.ts";
import { gettext } from "../kit/text.ts";
import type { RobotPage } from "../page/robot_page.ts";
import { Pads } from "./gamepad.ts";
import { KEEP_MS, onPress } from "./jog.ts";
import { byKeys, byPad, byPointer, isStickKey, dampedPush, type Push, REST } from "./stick_rules.ts";

const TICK_MS = 40;
const AGAIN_MS = 250; // a gamepad that stays pushed begins nothing sooner
export type StickBy = "pointer" | "touch" | "key" | "pad" | "";

export class Stick {
  readonly element: HTMLElement;
  /** What holds it now; empty while nothing does. */
  by: StickBy = "";
  /** The force that pushes the knob back while a pointer pushes it ahead, 0 to 1. */
  resistance = 0;
  private knob = make("span", { class: "stick-knob" });
  private seq = 0;
  private wanted: Push = REST;
  private at: Push = REST;
  private keys = new Set<string>();
  private pads = new Pads();
  private kept = 0;
  private last = 0;
  private ticked = 0;

  /** `args` are the values of the command for a push: x to the right, y up, each from -1 to 1. */
  constructor(
    private page: RobotPage,
    private kind: string,
    private args: (push: Push) => Record<string, number>,
    label = gettext("Stick"),
  ) {
    const how = gettext(
      "{name}: push it up for speed and to the side for steering, or hold the arrow keys here, with Shift for full speed",
      {
        name: label,
      },
    );
    const attributes = { class: "stick", tabindex: 0, role: "application", "aria-label": how, "aria-describedby": "why" };
    this.element = make("div", attributes, this.knob);
    this.listen();
    setInterval(() => this.tick(), TICK_MS);
  }

  /** Where the knob is. */
  get push(): Push {
    return this.at;
  }

  /** Enable the stick, or disable it with a reason; a motion that is held goes on. */
  enable(why: string): void {
    allow(this.element, this.seq ? "" : why);
  }

  private listen(): void {
    const { element } = this;
    const down = (event: PointerEvent): void => {
      this.wanted = this.pointed(event);
      this.begin(event.pointerType === "touch" ? "touch" : "pointer");
    };
    onPress(element, down, () => this.pointing && this.end());
    element.addEventListener("pointermove", (event) => {
      if (this.pointing) this.wanted = this.pointed(event);
    });
    element.addEventListener("keydown", (event) => this.key(event, true));
    element.addEventListener("keyup", (event) => this.key(event, false));
    element.addEventListener("focusout", () => this.by === "key" && this.end());
    for (const name of ["blur", "pagehide"]) addEventListener(name, () => this.end());
    document.addEventListener("visibilitychange", () => document.hidden && this.end());
  }

  private get pointing(): boolean {
    return this.by === "pointer" || this.by === "touch";
  }

  private pointed(event: PointerEvent): Push {
    const box = this.element.getBoundingClientRect();
    const right = event.clientX - box.left - box.width / 2,
      down = event.clientY - box.top - box.height / 2;
    return byPointer(right, down, Math.min(box.width, box.height) / 2);
  }

  private key(event: KeyboardEvent, down: boolean): void {
    if (event.key !== "Shift" && !isStickKey(event.key)) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key !== "Shift") event.preventDefault();
    event.stopPropagation();
    if (!down) this.keys.delete(event.key);
    else if (event.key !== "Shift") this.keys.add(event.key);
    const push = byKeys(this.keys, event.shiftKey);
    if (!push) {
      if (this.by === "key") this.end();
      return;
    }
    if (this.by === "" && down && !event.repeat) {
      this.wanted = push;
      this.begin("key");
    } else if (this.by === "key") this.wanted = push;
  }

  private feelPad(): void {
    const push = this.pads.wanted(this.element, byPad);
    if (this.by === "pad" && !push) this.end();
    else if (this.by === "pad" && push) this.wanted = push;
    else if (push && !this.by && document.hasFocus() && performance.now() - this.last > AGAIN_MS) {
      this.wanted = push;
      this.begin("pad");
    }
  }

  private begin(by: StickBy): void {
    if (this.seq) return;
    this.last = performance.now();
    const again = (): string => this.page.whyNot(this.kind),
      why = again();
    if (why && by === "pad") this.pads.forget(); // a stick that stays pushed begins nothing later
    if (why) return this.page.keepAlive.refused(why, again);
    this.by = by;
    this.at = dampedPush(REST, this.wanted, this.pointing ? this.resistance : 0, 0);
    this.kept = this.ticked = performance.now();
    this.seq = this.page.issue(this.kind, this.args(this.at));
    this.element.classList.add("held");
  }

  private tick(): void {
    this.feelPad();
    const now = performance.now();
    if (this.seq) {
      this.at = dampedPush(this.at, this.wanted, this.pointing ? this.resistance : 0, (now - this.ticked) / 1000);
      if (this.page.keepAlive.ended(this.seq)) this.end();
      else if (now - this.kept >= KEEP_MS - TICK_MS / 2) {
        this.kept = now;
        this.page.keepAlive.keep(this.seq, this.args(this.at));
      }
    }
    this.ticked = now;
    this.draw();
  }

  private draw(): void {
    const [x, y] = this.at;
    this.knob.style.setProperty("--x", x.toFixed(3));
    this.knob.style.setProperty("--y", (-y).toFixed(3));
  }

  /** End the motion. */
  end(): void {
    this.keys.clear();
    if (!this.seq) return;
    if (this.by === "pad") this.pads.forget();
    this.page.keepAlive.release(this.seq);
    [this.seq, this.by, this.wanted, this.at] = [0, "", REST, REST];
    this.last = performance.now();
    this.element.classList.remove("held");
    this.draw();
  }
}
