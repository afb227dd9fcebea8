/** A command as a form: a field for each of its values with unit and range, and a button. */
import { make } from "../kit/dom.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { gettext, translate } from "../kit/text.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { ArgumentInfo, CommandSpec } from "../socket/messages.ts";

/** What was typed, by the names of the values. */
export type Values = Readonly<Record<string, number | string>>;

export class CommandForm {
  readonly element = make("form", { class: "plain-command" });
  private fields: readonly (readonly [HTMLElement, HTMLInputElement, ArgumentInfo])[];
  private button: HTMLButtonElement;

  /** `onSend` gets the values of each command that is sent. */
  constructor(
    private page: RobotPage,
    private spec: CommandSpec,
    private onSend: (values: Values) => void = () => undefined,
  ) {
    this.fields = spec.arguments.map((argument) => this.field(argument));
    this.button = make("button", { class: "button", "aria-describedby": "why" }, spec.label);
    this.element.append(...this.fields.map(([label]) => label), this.button);
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      this.send();
    });
  }

  /** Write these values into the fields; the next press sends them. */
  fill(values: Values): void {
    for (const [, input, { name }] of this.fields) input.value = String(values[name] ?? "");
    this.button.focus();
  }

  /** Return the command in words: each value with its name and unit. */
  words(values: Values): string {
    const word = (argument: ArgumentInfo): string => `${titled(argument)} ${values[argument.name]} ${argument.unit}`.trim();
    const parts = this.spec.arguments.filter(({ name }) => name in values).map(word);
    return `${this.spec.label}: ${parts.join(", ")}`;
  }

  /** Enable the button, or disable it with a reason. */
  enable(why: string): void {
    allow(this.button, why);
  }

  private send(): void {
    if (refusal(this.button)) return this.page.refuse(() => refusal(this.button));
    const args: Record<string, number | string> = {};
    for (const [, input, argument] of this.fields) {
      if (argument.text ? input.value : Number.isFinite(input.valueAsNumber))
        args[argument.name] = argument.text ? input.value : input.valueAsNumber;
      else if (argument.required)
        return this.page.refuse(() => (input.value ? "" : gettext("Fill in {value} first.", { value: titled(argument) })));
    }
    if (this.page.command(this.spec.kind, args)) this.onSend(args);
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
