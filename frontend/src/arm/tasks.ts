/** Task mode: steps with the objects around the arm, tried on the ghost, run, saved, shared. */
import type { RobotPage } from "../page/robot_page.ts";
import type { PlanAnswer } from "../socket/messages.ts";
import { minutes, ProgramDesk } from "../widgets/program_desk.ts";
import { parseTask, printTask, type TaskStep } from "../widgets/task_text.ts";
import type { ArmMode, Judge, Target } from "./types.ts";
import { gettext, translate } from "../kit/text.ts";

const POSTURES = ["ready", "home"]; // of robot.toml

interface Arm extends Judge {
  refuse(why: string): void;
  play(answer: PlanAnswer): void;
}

export class Tasks implements ArmMode {
  readonly asked = "run-task";
  readonly empty = gettext("The task has no step.");
  private desk: ProgramDesk<TaskStep>;

  constructor(
    private page: RobotPage,
    private arm: Arm,
    { objects = [], plate }: { objects?: readonly { name: string }[]; plate?: object },
  ) {
    const names = objects.map(({ name }) => name);
    const use = {
      blocks: async (box: HTMLElement, changed: (steps: TaskStep[]) => void) =>
        new (await import("../widgets/task_desk.ts")).TaskBlocks(box, names, POSTURES, plate !== undefined, changed),
      changed: () => arm.ask(),
      refused: (why: string) => arm.refuse(why),
    };
    this.desk = new ProgramDesk<TaskStep>(page, { parse: parseTask, print: printTask }, gettext("task"), use, "task");
    page.on("try-task", () => arm.ask());
    page.on("run-task", () => page.command("task", { text: this.text() }, "run-task"));
  }

  open(): void {
    void this.desk.open();
  }

  tellRun(): void {
    const c = this.page.ladder.newest("task");
    if (c?.grant === this.page.grant) this.desk.follow(c);
  }

  fresh(): void {
    this.desk.fresh();
  }

  add(...steps: TaskStep[]): void {
    this.desk.add(...steps);
  }

  takeBack(...steps: TaskStep[]): void {
    this.desk.takeBack(...steps);
  }

  text(): string {
    return this.desk.text();
  }

  target(): Target | null {
    const text = this.text();
    return text ? { kind: "task", args: { text } } : null;
  }

  /** Show the server's answer to the task: it has checked it, or refuses it. */
  checked(answer: PlanAnswer): void {
    const said = answer.judgements ?? [];
    this.desk.judge(said);
    if (answer.ok)
      this.desk.tell(gettext("Checked with the objects as the arm knows them: {time}.", { time: minutes(answer.seconds ?? 0) }), "good");
    else this.desk.tell(said.length ? "" : translate(answer.text), "bad");
    if (answer.ok) this.arm.play(answer);
  }
}
