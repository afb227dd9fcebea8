/** Joint mode: a slider for each axis with its limits, and arrows that turn it while held. */
import { byId, make } from "../kit/dom.ts";
import { gettext } from "../kit/text.ts";
import { plain, sayWord } from "../page/plain_words.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { StatePacket } from "../socket/packets.ts";
import { Jog, named } from "../widgets/jog.ts";
import { deg, type JointInfo, type Judge, rad, type Target, TargetEdit } from "./types.ts";

export class Joints {
  private sliders: HTMLInputElement[] = [];
  private numbers: HTMLInputElement[] = [];
  private marks: HTMLElement[] = [];
  private edited = new TargetEdit();
  private box = byId("joints");
  private jog: Jog<Record<string, number>>;

  constructor(
    private page: RobotPage,
    private console: Judge,
    private infos: JointInfo[],
    private speed: () => number,
    kind: string,
  ) {
    this.box.append(...infos.map((info) => this.row(info)));
    document.querySelector('[data-fill="joints"]')?.addEventListener("click", () => this.take(page.state?.joints ?? []));
    this.jog = new Jog(this.box, {
      read: named,
      whyNot: () => console.whyNot("jog", page.facts()),
      begin: (way) => page.issue(kind, way),
      ...page.keepAlive,
    });
  }

  private row({ name, low, high }: JointInfo): HTMLElement {
    const range = { min: Math.ceil(deg(low)), max: Math.floor(deg(high)), value: 0 };
    const slider = make("input", { ...range, type: "range", step: 0.5, id: `joint-${name}`, "aria-valuetext": degrees("0") });
    const word = plain(name);
    const spoken = gettext("{joint} in degrees, {low} to {high}", { joint: word, low: range.min, high: range.max });
    const number = make("input", { ...range, type: "number", step: "any", "aria-label": spoken });
    const label = make("label", { for: slider.id });
    sayWord(label, name);
    const mark = make("i", { "aria-hidden": "true" });
    const chosen = (value: string): void => {
      this.edited.note(this.page.lastSeq);
      if (value !== "") slider.value = value;
      this.console.ask();
    };
    slider.addEventListener("input", () => {
      number.value = slider.value;
      slider.setAttribute("aria-valuetext", degrees(slider.value));
      chosen(slider.value);
    });
    number.addEventListener("input", () => chosen(number.value));
    this.sliders.push(slider);
    this.numbers.push(number);
    this.marks.push(mark);
    return make(
      "div",
      { class: "joint" },
      label,
      jogButton(`${name},-1`, "−", gettext("{joint}: turn back while held", { joint: word })),
      make("span", { class: "track" }, slider, mark),
      jogButton(`${name},1`, "+", gettext("{joint}: turn on while held", { joint: word })),
      number,
    );
  }

  /** Show the arm's joints; the sliders follow until somebody moves one. */
  show(packet: StatePacket): void {
    this.infos.forEach((info, i) => {
      const share = ((packet.joints[i] ?? 0) - info.low) / (info.high - info.low);
      this.marks[i]?.style.setProperty("inset-inline-start", `${Math.min(100, Math.max(0, share * 100))}%`);
    });
    if (!this.edited.now) this.fill(packet.joints);
  }

  /** Let the sliders follow the arm again after that motion, unless somebody has moved one since it was given. */
  arrived(seq: number): void {
    this.edited.arrived(seq);
  }

  take(joints: number[]): void {
    this.edited.forget();
    this.fill(joints);
    this.console.ask();
  }

  /** Fill in a target. */
  put(joints: readonly number[]): void {
    this.edited.note(this.page.lastSeq);
    this.fill(joints);
    this.console.ask();
  }

  private fill(joints: readonly number[]): void {
    this.infos.forEach((_, i) => {
      const value = deg(joints[i] ?? 0).toFixed(1);
      const slider = this.sliders[i],
        number = this.numbers[i];
      if (!slider || !number || number.value === value) return;
      slider.value = number.value = value;
      slider.setAttribute("aria-valuetext", degrees(value));
    });
  }

  /** Return the filled-in joints; null if one is not a number. */
  target(): Target | null {
    const values = this.numbers.map((n) => n.valueAsNumber);
    if (values.some((v) => !Number.isFinite(v))) return null;
    const args: Target["args"] = { speed: this.speed() };
    this.infos.forEach((info, i) => (args[info.name] = rad(values[i] ?? 0)));
    return { kind: "joints", args };
  }

  enable(why: string): void {
    this.jog.enable(why);
  }
}

function degrees(value: string): string {
  return gettext("{value} degrees", { value });
}

export function jogButton(jog: string, sign: string, label: string): HTMLButtonElement {
  const name = /[a-z]/.test(sign) ? `${sign}: ${label}` : label;
  const attributes = { type: "button", class: "button", "data-jog": jog, "aria-label": name, "aria-describedby": "why" };
  return make("button", attributes, sign);
}
