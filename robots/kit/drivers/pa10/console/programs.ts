/** Program mode: steps as blocks and as text, tried on the ghost, run, saved, shared. */
import { deg, type Judge } from "/static/farhand/v1/arm.js";
import { type PlanAnswer, type RobotPage } from "/static/farhand/v1/console.js";
import { ProgramDesk } from "/static/farhand/v1/programs.js";
import { parse, print, type Step } from "./program_text.ts";
import { gettext, translate } from "/static/farhand/v1/text.js";

interface Arm extends Judge {
  refuse(why: string): void;
  tool(): number[] | null;
  play(answer: PlanAnswer): void;
}

export class Programs {
  private desk: ProgramDesk<Step>;

  constructor(
    private page: RobotPage,
    private arm: Arm,
    private axes: string[],
  ) {
    this.desk = new ProgramDesk<Step>(page, { parse, print }, gettext("program"), {
      blocks: async (box, changed) => new (await import("./blocks.ts")).Blocks(box, axes, changed),
      changed: () => arm.ask(),
      refused: (why) => arm.refuse(why),
    });
    const act: Record<string, () => void> = { here: () => this.addHere(), joints: () => this.addJoints() };
    for (const [name, run] of Object.entries(act)) document.querySelector(`[data-program="${name}"]`)?.addEventListener("click", run);
    page.on("try", () => arm.ask());
    page.on("run", () => page.command("program", { text: this.text() }, "run"));
  }

  async open(): Promise<void> {
    await this.desk.open();
  }

  text(): string {
    return this.desk.text();
  }

  private addHere(): void {
    const here = this.arm.tool();
    if (!here) return;
    const values = [...here.slice(0, 3).map((v) => v * 1000), ...here.slice(3).map(deg)].map(tenth);
    this.desk.add({ do: "pose", straight: false, values });
  }

  private addJoints(): void {
    const { state } = this.page;
    if (state) this.desk.add({ do: "joints", values: state.joints.slice(0, this.axes.length).map((q) => tenth(deg(q))) });
  }

  /** Show the server's answer to the program: it has checked it, or refuses it. */
  checked(answer: PlanAnswer): void {
    const said = answer.judgements ?? [];
    this.desk.judge(said);
    if (answer.ok)
      this.desk.tell(gettext("Checked: {seconds} s, no forbidden box is touched.", { seconds: answer.seconds?.toFixed(0) ?? "?" }), "good");
    else this.desk.tell(said.length ? "" : translate(answer.text), "bad");
    if (answer.ok) this.arm.play(answer);
  }

  tellRun(): void {
    const c = this.page.ladder.newest("program");
    if (c?.grant === this.page.grant) this.desk.follow(c);
  }
}

function tenth(value: number): number {
  return Math.round(value * 10) / 10;
}
