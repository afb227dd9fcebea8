/** Task mode: steps with the blocks on the table, tried on the ghost, run, saved, shared. */
import { type Judge } from "/static/farhand/v1/arm.js";
import { type PlanAnswer, type RobotPage } from "/static/farhand/v1/console.js";
import { minutes, parseTask, printTask, ProgramDesk, type TaskStep } from "/static/farhand/v1/programs.js";

interface Arm extends Judge {
  refuse(why: string): void;
  play(answer: PlanAnswer): void;
}

export class Tasks {
  private desk: ProgramDesk<TaskStep>;

  constructor(
    page: RobotPage,
    private arm: Arm,
    names: readonly string[],
    postures: readonly string[],
  ) {
    const use = {
      blocks: async (box: HTMLElement, changed: (steps: TaskStep[]) => void) =>
        new (await import("/static/farhand/v1/blocks.js")).TaskBlocks(box, names, postures, changed),
      changed: () => arm.ask(),
      refused: (why: string) => arm.refuse(why),
    };
    this.desk = new ProgramDesk<TaskStep>(page, { parse: parseTask, print: printTask }, "task", use, "task");
    page.on("try-task", () => arm.ask());
    page.on("run-task", () => {
      if (page.command("task", { text: this.text() }, "run-task")) this.desk.tell("The task runs; its present line is shown.", "");
    });
  }

  async open(): Promise<void> {
    await this.desk.open();
  }

  text(): string {
    return this.desk.text();
  }

  /** Show the server's answer to the task: it has checked it, or refuses it. */
  checked(answer: PlanAnswer): void {
    const said = answer.judgements ?? [];
    this.desk.judge(said);
    if (answer.ok) this.desk.tell(`Checked with the objects as the arm knows them: ${minutes(answer.seconds ?? 0)}.`, "good");
    else this.desk.tell(said.length ? "" : answer.text, "bad");
    if (answer.ok) this.arm.play(answer);
  }
}
