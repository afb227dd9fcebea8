/** A command as a form: a field for each of its values with unit and range, and a button. */
import { allow, refusal } from "../kit/refusal.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { ArgumentInfo, CommandSpec } from "../socket/messages.ts";

export class CommandForm {
  readonly element = document.createElement("form");
  private button = document.createElement("button");

  constructor(
    private page: RobotPage,
    private spec: CommandSpec,
  ) {
    this.element.className = "plain-command";
    const fields = spec.arguments.map((argument) => this.field(argument));
    this.button.className = "button";
    this.button.textContent = spec.label;
    this.button.setAttribute("aria-describedby", "why");
    this.element.append(...fields.map(([label]) => label), this.button);
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      this.send(fields);
    });
  }

  /** Enable the button, or disable it with a reason. */
  enable(why: string): void {
    allow(this.button, why);
  }

  private send(fields: readonly (readonly [HTMLElement, HTMLInputElement, ArgumentInfo])[]): void {
    if (refusal(this.button)) return this.page.refuse(() => refusal(this.button));
    const args: Record<string, number | string> = {};
    for (const [, input, argument] of fields) {
      if (argument.text ? input.value : Number.isFinite(input.valueAsNumber))
        args[argument.name] = argument.text ? input.value : input.valueAsNumber;
      else if (argument.required) return this.page.refuse(() => (input.value ? "" : `Fill in ${titled(argument)} first.`));
    }
    this.page.command(this.spec.kind, args);
  }

  private field(argument: ArgumentInfo): readonly [HTMLElement, HTMLInputElement, ArgumentInfo] {
    const label = document.createElement("label");
    const input = document.createElement("input");
    const unit = argument.unit ? ` (${argument.unit})` : "";
    const range = argument.text ? "" : `${round(argument.low)} to ${round(argument.high)}`;
    label.textContent = `${titled(argument)}${unit} `;
    label.title = argument.help;
    Object.assign(input, { type: argument.text ? "text" : "number", id: `${this.spec.kind}-${argument.name}`, placeholder: range });
    if (!argument.text) Object.assign(input, { min: String(argument.low), max: String(argument.high), step: argument.whole ? "1" : "any" });
    label.append(input);
    return [label, input, argument];
  }
}

/** What a value is called. */
function titled({ label, name }: ArgumentInfo): string {
  return label || name.replaceAll("_", " ");
}

function round(value: number): number {
  return Math.round(value * 1000) / 1000;
}
