/** Joint mode: a slider for each axis with its limits, and arrows that turn it while held. */
import { byId } from "../kit/dom.ts";
import { allow } from "../kit/refusal.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { StatePacket } from "../socket/packets.ts";
import { Jog, named } from "../widgets/jog.ts";
import { TargetEdit } from "./target_edit.ts";
import { deg, type JointInfo, type Judge, rad, type Target } from "./types.ts";

export class Joints {
  private sliders: HTMLInputElement[] = [];
  private numbers: HTMLInputElement[] = [];
  private marks: HTMLElement[] = [];
  private edited = new TargetEdit();
  private box = byId("joints");

  constructor(
    private page: RobotPage,
    private console: Judge,
    private infos: JointInfo[],
    private speed: () => number,
    kind: string,
  ) {
    this.box.append(...infos.map((info) => this.row(info)));
    document.querySelector('[data-fill="joints"]')?.addEventListener("click", () => this.take(page.state?.joints ?? []));
    new Jog<Record<string, number>>(this.box, {
      read: named,
      arrows: {},
      stick: () => null,
      whyNot: () => console.whyNot("jog", page.facts()),
      begin: (way) => page.issue(kind, way),
      ...page.keepAlive,
    });
  }

  private row(info: JointInfo): HTMLElement {
    const row = document.createElement("div");
    row.className = "joint";
    const low = Math.ceil(deg(info.low)),
      high = Math.floor(deg(info.high));
    const label = document.createElement("label");
    label.textContent = info.name;
    label.htmlFor = `joint-${info.name}`;
    const slider = input("range", low, high, `joint-${info.name}`);
    slider.setAttribute("aria-valuetext", "0 degrees");
    const number = input("number", low, high, "");
    number.setAttribute("aria-label", `${info.name} in degrees, ${low} to ${high}`);
    const track = document.createElement("span");
    track.className = "track";
    const mark = document.createElement("i");
    mark.setAttribute("aria-hidden", "true");
    track.append(slider, mark);
    const set = (value: string): void => {
      this.edited.note(this.page.lastSeq);
      slider.value = number.value = value;
      slider.setAttribute("aria-valuetext", `${value} degrees`);
      this.console.ask();
    };
    slider.addEventListener("input", () => set(slider.value));
    number.addEventListener("input", () => {
      this.edited.note(this.page.lastSeq);
      if (number.value !== "") slider.value = number.value;
      this.console.ask();
    });
    row.append(
      label,
      jogButton(`${info.name},-1`, "−", `Turn ${info.name} back while held`),
      track,
      jogButton(`${info.name},1`, "+", `Turn ${info.name} on while held`),
      number,
    );
    this.sliders.push(slider);
    this.numbers.push(number);
    this.marks.push(mark);
    return row;
  }

  /** Show the arm's joints; the sliders follow until somebody moves one. */
  show(packet: StatePacket): void {
    this.infos.forEach((info, i) => {
      const share = ((packet.joints[i] ?? 0) - info.low) / (info.high - info.low);
      this.marks[i]?.style.setProperty("inset-inline-start", `${Math.min(100, Math.max(0, share * 100))}%`);
    });
    if (!this.edited.now) this.fill(packet.joints);
  }

  /** A motion has ended: the sliders follow again, unless somebody has moved one since it was given. */
  arrived(seq: number): void {
    this.edited.arrived(seq);
  }

  take(joints: number[]): void {
    this.edited.forget();
    this.fill(joints);
    this.console.ask();
  }

  private fill(joints: number[]): void {
    this.infos.forEach((_, i) => {
      const value = deg(joints[i] ?? 0).toFixed(1);
      const slider = this.sliders[i],
        number = this.numbers[i];
      if (!slider || !number || number.value === value) return;
      slider.value = number.value = value;
      slider.setAttribute("aria-valuetext", `${value} degrees`);
    });
  }

  /** The filled-in joints; null if one is not a number, or nothing was chosen yet. */
  target(): Target | null {
    const values = this.numbers.map((n) => n.valueAsNumber);
    if (values.some((v) => !Number.isFinite(v))) return null;
    const args: Target["args"] = { speed: this.speed() };
    this.infos.forEach((info, i) => (args[info.name] = rad(values[i] ?? 0)));
    return { kind: "joints", args };
  }

  enable(why: string): void {
    const busy = this.box.classList.contains("held");
    for (const button of this.box.querySelectorAll<HTMLElement>("[data-jog]")) allow(button, busy ? "" : why);
  }
}

function input(type: string, low: number, high: number, id: string): HTMLInputElement {
  const made = document.createElement("input");
  Object.assign(made, { type, min: String(low), max: String(high), step: type === "range" ? "0.5" : "any", value: "0" });
  if (id) made.id = id;
  return made;
}

export function jogButton(jog: string, sign: string, label: string): HTMLButtonElement {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "button";
  button.dataset["jog"] = jog;
  button.setAttribute("aria-label", /[a-z]/.test(sign) ? `${sign}: ${label}` : label);
  button.setAttribute("aria-describedby", "why");
  button.textContent = sign;
  return button;
}
