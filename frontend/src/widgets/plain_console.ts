/** The console of a robot without one of its own: its controls are drawn from its spec. */
import { byId } from "../kit/dom.ts";
import { fill } from "../kit/render.ts";
import { Basics } from "../page/console.ts";
import type { Facts } from "../page/controls.ts";
import { facts } from "../page/facts.ts";
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
    fill(
      byId("readings").querySelector("tbody")!,
      [...facts.names.map((name) => [name, ""]), ...[...facts.pose, ...facts.channels].map((c) => [c.name, ` ${c.unit}`])].map(
        ([name, unit]) => {
          const value = this.page.value(name!);
          return [name!, value === undefined ? "not known" : `${value.toFixed(3)}${unit}`];
        },
      ),
    );
  }

  override draw(f: Facts): void {
    this.box.hidden = !this.page.operating;
    for (const { kind, made } of this.widgets) made.enable(this.whyNot(kind, f));
  }
}

const page = new RobotPage();
page.begin(new PlainConsole(page));
