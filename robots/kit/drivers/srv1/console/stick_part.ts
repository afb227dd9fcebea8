/** The stick for driving by hand, and what is felt while it is held. */
import { make, type RobotPage } from "/static/farhand/v1/console.js";
import { Stick } from "/static/farhand/v1/roaming.js";
import { buzz, EVERY_MS, force, type Ranges, rumble } from "./force.ts";
import { gettext } from "/static/farhand/v1/text.js";

const KEPT = "farhand:srv1:force";

export class StickPart {
  private stick: Stick;
  private on = make("input", { type: "checkbox" });
  private still = matchMedia("(prefers-reduced-motion: reduce)");

  constructor(
    private page: RobotPage,
    private ranges: Ranges,
    pad: HTMLElement,
  ) {
    this.stick = new Stick(page, "drive", ([x, y]) => ({ forward: rounded(y), turn: rounded(-x) }), gettext("Drive by hand"));
    this.on.checked = kept() !== "off";
    this.on.addEventListener("change", () => keep(this.on.checked ? "on" : "off"));
    pad.prepend(this.stick.element);
    pad.append(
      make("label", { class: "feel" }, this.on, ` ${gettext("Feel what is near: the stick resists, a gamepad or a phone shakes")}`),
    );
    setInterval(() => this.feel(), EVERY_MS);
  }

  enable(why: string): void {
    this.stick.enable(why);
  }

  /** Let the knob resist by the newest state. */
  state(): void {
    this.stick.resistance = this.still.matches ? 0 : this.level();
  }

  private level(): number {
    if (!this.on.checked || !this.stick.by) return 0;
    return force(this.page.value("infrared"), this.page.value("sonar"), this.stick.push[1] || 1, this.ranges);
  }

  private feel(): void {
    const { by, push } = this.stick;
    const level = push[1] > 0 ? this.level() : 0;
    if (by === "touch" && buzz(level) && "vibrate" in navigator) navigator.vibrate(buzz(level));
    const effect = by === "pad" ? rumble(level) : null;
    if (effect)
      for (const pad of navigator.getGamepads())
        void (pad as Partial<Gamepad> | null)?.vibrationActuator?.playEffect("dual-rumble", effect).catch(() => undefined); // one that cannot
  }
}

function rounded(share: number): number {
  return Math.round(share * 1000) / 1000;
}

function kept(): string | null {
  try {
    return localStorage.getItem(KEPT);
  } catch {
    return null; // this browser keeps nothing
  }
}

function keep(value: string): void {
  try {
    localStorage.setItem(KEPT, value);
  } catch {
    // see `kept`
  }
}
