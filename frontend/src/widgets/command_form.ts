/** A command as a form: a field for each of its values with unit and range, and a button. */
import { make } from "../kit/dom.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { gettext, translate } from "../kit/text.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { ArgumentInfo, CommandSpec } from "../socket/messages.ts";

export class CommandForm {
  readonly element = make("form", { class: "plain-command" });
  private button: HTMLButtonElement;

  constructor(
    private page: RobotPage,
    private spec: CommandSpec,
  ) {
    const fields = spec.arguments.map((argument) => this.field(argument));
    this.button = make("button", { class: "button", "aria-describedby": "why" }, spec.label);
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
      else if (argument.required)
        return this.page.refuse(() => (input.value ? "" : gettext("Fill in {value} first.", { value: titled(argument) })));
    }
    this.page.command(this.spec.kind, args);
  }

  private field(argument: ArgumentInfo): readonly [HTMLElement, HTMLInputElement, ArgumentInfo] {
    const { low, high, name, help, text, whole } = argument;
    const unit = argument.unit ? ` (${argument.unit})` : "";
    const numbers = {
      type: "number",
      min: low,
      max: high,
      step: whole ? "1" : "any",
      placeholder: gettext("{low} to {high}", { low: round(low), high: round(high) }),
    };
    const input = make("input", { id: `${this.spec.kind}-${name}`, ...(text ? { type: "text" } : numbers) });
    return [make("label", { title: help }, `${titled(argument)}${unit} `, input), input, argument];
  }
}

/** Return what a value is called. */
function titled({ label, name }: ArgumentInfo): string {
  return label || translate(name.replaceAll("_", " "));
}

function round(value: number): number {
  return Math.round(value * 1000) / 1000;
}
