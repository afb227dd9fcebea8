/** Position mode: fields for the tool's position and rotation, and arrows that move it while held. */
import { byId, make } from "../kit/dom.ts";
import { gettext } from "../kit/text.ts";
import { facts } from "../page/facts.ts";
import type { RobotPage } from "../page/robot_page.ts";
import { twist } from "../widgets/gamepad.ts";
import { Jog, named } from "../widgets/jog.ts";
import { jogButton } from "./joints.ts";
import { deg, type Judge, rad, rangeError, type Target, TargetEdit } from "./types.ts";

const PLACE = [
  ["x", "mm", gettext("forward")],
  ["y", "mm", gettext("to the left")],
  ["z", "mm", gettext("above the table")],
  ["roll", "°", gettext("about x")],
  ["pitch", "°", gettext("about y")],
  ["yaw", "°", gettext("about z")],
] as const;
const [ROLL, PITCH, YAW] = [gettext("roll"), gettext("pitch"), gettext("yaw")];
const NAMES: Readonly<Record<string, string>> = { roll: ROLL, pitch: PITCH, yaw: YAW };
const ARROWS = [
  ["x,1", "x +", gettext("Move the tool away from the base")],
  ["x,-1", "x −", gettext("Move the tool towards the base")],
  ["y,1", "y +", gettext("Move the tool to the left")],
  ["y,-1", "y −", gettext("Move the tool to the right")],
  ["z,1", "z +", gettext("Move the tool up")],
  ["z,-1", "z −", gettext("Move the tool down")],
  ["roll,1", `${ROLL} +`, gettext("Turn the tool about x")],
  ["roll,-1", `${ROLL} −`, gettext("Turn the tool back about x")],
  ["pitch,1", `${PITCH} +`, gettext("Turn the tool about y")],
  ["pitch,-1", `${PITCH} −`, gettext("Turn the tool back about y")],
  ["yaw,1", `${YAW} +`, gettext("Turn the tool about z")],
  ["yaw,-1", `${YAW} −`, gettext("Turn the tool back about z")],
] as const;
const OVER_M = 0.15;

export class Position {
  private inputs: HTMLInputElement[] = [];
  private edited = new TargetEdit();
  private straight = byId<HTMLInputElement>("straight");
  private pad = byId("tool-jog");
  private jog: Jog<Record<string, number>>;

  constructor(
    private page: RobotPage,
    private console: Judge,
    private speed: () => number,
    private tool: () => number[] | null,
    kind: string,
  ) {
    byId("pose").append(...PLACE.map(([name, unit, hint]) => this.field(name, unit, hint)));
    this.straight.addEventListener("change", () => console.ask());
    document.querySelector('[data-fill="pose"]')?.addEventListener("click", () => this.take());
    document.querySelector('[data-fill="down"]')?.addEventListener("click", () => this.down());
    this.pad.prepend(...ARROWS.map(([jog, sign, label]) => jogButton(jog, sign, label)));
    this.jog = new Jog(this.pad, {
      read: named,
      arrows: {
        ArrowUp: { x: 1 },
        ArrowDown: { x: -1 },
        ArrowLeft: { y: 1 },
        ArrowRight: { y: -1 },
        PageUp: { z: 1 },
        PageDown: { z: -1 },
      },
      stick: twist,
      whyNot: () => console.whyNot("jog", page.facts()),
      begin: (way) => page.issue(kind, way),
      ...page.keepAlive,
    });
  }

  private field(name: string, unit: string, hint: string): HTMLElement {
    const id = `pose-${name}`;
    const input = make("input", { type: "number", step: "any", id, "aria-describedby": `${id}-hint` });
    input.addEventListener("input", () => {
      this.edited.note(this.page.lastSeq);
      this.console.ask();
    });
    this.inputs.push(input);
    return make("label", {}, make("span", {}, `${NAMES[name] ?? name} (${unit})`), input, make("small", { id: `${id}-hint` }, hint));
  }

  /** Show the tool's present pose, until somebody fills in another. */
  follow(): void {
    const here = this.edited.now ? null : this.tool();
    if (here) this.fill([...here.slice(0, 3).map((v) => v * 1000), ...here.slice(3).map(deg)]);
  }

  /** Let the fields follow the arm again after that motion, unless somebody has filled in something since it was given. */
  arrived(seq: number): void {
    this.edited.arrived(seq);
    this.follow();
  }

  /** Fill in the tool's present pose. */
  take(): void {
    this.edited.forget();
    this.follow();
    this.console.ask();
  }

  /** Fill in a place on the table (m): some way above it, with the tool pointing down. */
  place(x: number, y: number): void {
    this.set([x * 1000, y * 1000, OVER_M * 1000, 180, 0, 180]);
  }

  private down(): void {
    const now = this.inputs.map((i) => i.valueAsNumber);
    this.set([now[0] ?? NaN, now[1] ?? NaN, now[2] ?? NaN, 180, 0, 180]);
  }

  private set(values: number[]): void {
    this.edited.note(this.page.lastSeq);
    this.fill(values);
    this.console.ask();
  }

  private fill(values: number[]): void {
    this.inputs.forEach((field, i) => {
      const value = values[i] ?? NaN,
        words = String(Math.round(value * 10) / 10);
      if (Number.isFinite(value) && field.value !== words) field.value = words;
    });
  }

  /** Return why a value lies outside its range, in the unit of its field; empty if none does. */
  outside(): string {
    const kind = this.target()?.kind,
      given = facts.commands.find((c) => c.kind === kind)?.arguments ?? [];
    const why = PLACE.map(([name, unit], i) => {
      const argument = given.find((a) => a.name === name);
      return argument ? rangeError(name, this.inputs[i]?.valueAsNumber ?? NaN, unit, i < 3 ? 1000 : deg(1), argument) : "";
    });
    return why.find(Boolean) ?? "";
  }

  /** Return the filled-in pose; null if a value is missing. */
  target(): Target | null {
    const values = this.inputs.map((i) => i.valueAsNumber);
    if (values.some((v) => !Number.isFinite(v))) return null;
    const args: Target["args"] = { speed: this.speed() };
    PLACE.forEach(([name], i) => (args[name] = i < 3 ? (values[i] ?? 0) / 1000 : rad(values[i] ?? 0)));
    return { kind: this.straight.checked ? "line" : "pose", args };
  }

  enable(why: string): void {
    this.jog.enable(why);
  }
}
