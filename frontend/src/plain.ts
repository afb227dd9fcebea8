/** The console of a robot nobody wrote one for: its controls draw themselves from what the driver says it takes. */
import { CameraView } from "./camera.ts";
import { blocked, type Facts } from "./controls.ts";
import { Jog, named } from "./jog.ts";
import { type Console, facts, RobotPage, text } from "./page.ts";
import { allow, fill, refusal } from "./parts.ts";
import type { ArgumentInfo, CommandSpec, StatePacket, Still } from "./protocol.ts";
import { byId } from "./svg.ts";
import { OneCamera } from "./one_camera.ts";

const page = new RobotPage();

class PlainConsole extends OneCamera implements Console {
  protected camera = new CameraView(byId("screen"), byId<HTMLCanvasElement>("picture"), null, () => undefined);
  private buttons: HTMLElement[] = [];
  private box = byId("commands");

  constructor() {
    super(() => page.draw());
    for (const spec of facts.commands) this.box.append(spec.held ? this.heldForm(spec) : this.form(spec));
  }

  private form(spec: CommandSpec): HTMLElement {
    const form = document.createElement("form");
    form.className = "plain-command";
    const fields = spec.arguments.map((argument) => this.field(spec, argument));
    const button = document.createElement("button");
    button.className = "button";
    button.textContent = spec.label;
    button.setAttribute("aria-describedby", "why");
    this.buttons.push(button);
    form.append(...fields.map(([label]) => label), button);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const why = refusal(button);
      if (why) return page.notice(why, "warning");
      const args: Record<string, number | string> = {};
      for (const [, input, argument] of fields) {
        if (argument.text ? input.value : Number.isFinite(input.valueAsNumber)) args[argument.name] = argument.text ? input.value : input.valueAsNumber;
        else if (argument.required) return page.notice(`Fill in ${argument.name} first.`, "warning");
      }
      page.command(spec.kind, args);
    });
    return form;
  }

  private field(spec: CommandSpec, argument: ArgumentInfo): [HTMLElement, HTMLInputElement, ArgumentInfo] {
    const label = document.createElement("label");
    const input = document.createElement("input");
    const unit = argument.unit ? ` (${argument.unit})` : "";
    const range = argument.text ? "" : `${round(argument.low)} to ${round(argument.high)}`;
    label.textContent = `${argument.name}${unit} `;
    Object.assign(input, { type: argument.text ? "text" : "number", id: `${spec.kind}-${argument.name}`, placeholder: range });
    if (!argument.text) Object.assign(input, { min: String(argument.low), max: String(argument.high), step: "any" });
    label.append(input);
    return [label, input, argument];
  }

  /** A held motion has a pair of buttons for each of its values, which are shares of full speed. */
  private heldForm(spec: CommandSpec): HTMLElement {
    const group = document.createElement("div");
    group.className = "plain-command";
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", `${spec.label}: hold to move`);
    for (const argument of spec.arguments)
      for (const [way, sign] of [[-1, "−"], [1, "+"]] as const) {
        const button = document.createElement("button");
        Object.assign(button, { type: "button", className: "button", textContent: `${argument.name} ${sign}` });
        button.dataset["jog"] = `${argument.name},${way}`;
        button.setAttribute("aria-describedby", "why");
        group.append(button);
        this.buttons.push(button);
      }
    new Jog<Record<string, number>>(group, {
      read: named,
      arrows: {}, stick: () => null,
      whyNot: () => this.whyNot(spec.kind, page.facts()),
      begin: (way) => page.issue(spec.kind, way),
      ...page.hand,
    });
    return group;
  }

  state(packet: StatePacket): void {
    text("mode", packet.mode);
    fill(byId("readings").querySelector("tbody")!, facts.names.map((name, i) => [name, (packet.joints[i] ?? 0).toFixed(3)]));
  }

  still(still: Still): void {
    this.camera.still(still, () => page.draw());
  }

  turn(): void {}

  command(): void {}

  whyNot(_: string, f: Facts): string {
    return blocked(f) || (f.busy ? "One command at a time: the robot is still busy." : "");
  }

  advice(f: Facts): string {
    return f.busy ? "The robot is busy." : "";
  }

  draw(f: Facts): void {
    this.box.hidden = !page.operating;
    const why = this.whyNot("", f);
    for (const button of this.buttons) {
      const held = button.parentElement?.classList.contains("held") ?? false;
      allow(button, held ? "" : why);
    }
  }
}

function round(value: number): number {
  return Math.round(value * 1000) / 1000;
}

page.begin(new PlainConsole());
