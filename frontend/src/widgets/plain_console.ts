/** The console of a robot that brings none: its controls are made from its spec. */
import { html } from "lit-html";
import { byId } from "../kit/dom.ts";
import { type Cell, drawParts, fill, type Part } from "../kit/render.ts";
import { decimals, gettext } from "../kit/text.ts";
import { Basics } from "../page/console.ts";
import type { Facts } from "../page/controls.ts";
import { facts } from "../page/facts.ts";
import { worded } from "../page/plain_words.ts";
import { RobotPage } from "../page/robot_page.ts";
import type { ArgumentInfo, CommandSpec } from "../socket/messages.ts";
import type { StatePacket } from "../socket/packets.ts";
import { CommandForm, type Values } from "./command_form.ts";
import { GoBack } from "./go_back.ts";
import { HeldButtons } from "./held_buttons.ts";

/** A command of this turn, and the form that sends it again. */
interface Recent {
  key: string;
  form: CommandForm;
  values: Values;
}
const MOST = 5;
/** The motions to a position: what shows each value that they need. */
const moves = facts.commands.filter(({ lane, held, arguments: values, shown }) => {
  const needed = values.filter(({ required, name }) => required || name in shown);
  return lane === "motion" && !held && needed.length > 0 && needed.every(({ name, text }) => name in shown && !text);
});
const places = [...new Set(moves.flatMap(({ shown }) => Object.values(shown)))];

class PlainConsole extends Basics<RobotPage> {
  private box = byId("commands");
  private recent: readonly Recent[] = [];
  private widgets = facts.commands.map((spec) => ({
    kind: spec.kind,
    made: spec.held ? new HeldButtons(this.page, spec) : this.form(spec),
  }));
  private back = new GoBack(this.page, {
    kinds: moves.map(({ kind }) => kind),
    joints: () => {
      const here = places.map((name) => this.page.value(name));
      return here.includes(undefined) ? [] : (here as number[]);
    },
    whyNot: () => this.whyNot("", this.page.facts()),
    choose: (values, kind) => {
      const { shown, arguments: named } = moves.find((spec) => spec.kind === kind)!;
      const form = this.widgets.find((one) => one.kind === kind)!.made as CommandForm;
      const set = named.filter(({ name }) => name in shown);
      form.fill(Object.fromEntries(set.map((one) => [one.name, within(one, values[places.indexOf(shown[one.name]!)]!)])));
    },
  });

  constructor(page: RobotPage) {
    super(page);
    this.box.append(...this.widgets.map(({ made }) => made.element));
  }

  private form(spec: CommandSpec): CommandForm {
    const form: CommandForm = new CommandForm(this.page, spec, (values) => {
      const key = `${spec.kind} ${JSON.stringify(values)}`;
      if (!Object.keys(values).length) return;
      this.recent = [{ key, form, values }, ...this.recent.filter((one) => one.key !== key)].slice(0, MOST);
      this.page.draw();
    });
    return form;
  }

  override turn(): void {
    this.recent = [];
  }

  override state(packet: StatePacket): void {
    super.state(packet);
    const row = (name: string, unit: string): Cell[] => {
      const value = this.page.value(name);
      return [worded(name), value === undefined ? gettext("not known") : `${decimals(value, 3)}${unit}`];
    };
    const joints = facts.names.map((name) => row(name, ""));
    const others = [...facts.pose, ...facts.channels].map(({ name, unit }) => row(name, ` ${unit}`));
    fill(byId("readings").querySelector("tbody")!, [...joints, ...others]);
  }

  override draw(f: Facts): void {
    this.box.hidden = !this.page.operating;
    for (const { kind, made } of this.widgets) made.enable(this.whyNot(kind, f));
    byId("back").hidden = !this.page.operating || !moves.length;
    this.back.draw();
    byId("recent-values").hidden = !this.page.operating || !facts.commands.some((spec) => !spec.held && spec.arguments.length);
    const item = ({ key, form, values }: Recent): Part => ({
      key,
      template: html`<li>
        <button type="button" class="button" @click=${() => form.fill(values)}>${form.words(values)}</button>
      </li>`,
    });
    drawParts(byId("recent"), this.recent.map(item));
  }
}

/** Return a value as its field takes it. */
function within({ low, high, whole }: ArgumentInfo, value: number): number {
  return Math.min(high, Math.max(low, whole ? Math.round(value) : Number(value.toPrecision(6))));
}

const page = new RobotPage();
page.begin(new PlainConsole(page));
