/** The console of a robot that brings none: its controls are made from its spec. */
import { byId } from "../kit/dom.ts";
import { type Cell, fill } from "../kit/render.ts";
import { decimals, gettext } from "../kit/text.ts";
import { Basics } from "../page/console.ts";
import type { Facts } from "../page/controls.ts";
import { facts } from "../page/facts.ts";
import { worded } from "../page/plain_words.ts";
import { RobotPage } from "../page/robot_page.ts";
import type { StatePacket } from "../socket/packets.ts";
import { CommandForm } from "./command_form.ts";
import { HeldButtons } from "./held_buttons.ts";

class PlainConsole extends Basics<RobotPage> {
  private box = byId("commands");
  private widgets = facts.commands.map((spec) => ({
    kind: spec.kind,
    made: spec.held ? new HeldButtons(this.page, spec) : new CommandForm(this.page, spec),
  }));

  constructor(page: RobotPage) {
    super(page);
    this.box.append(...this.widgets.map(({ made }) => made.element));
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
  }
}

const page = new RobotPage();
page.begin(new PlainConsole(page));
