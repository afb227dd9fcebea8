/** Records a task from the ghost by buttons and keys: its lines appear in the text of the task mode. Nothing is sent. */
import { byId, say, sayLines, set } from "../kit/dom.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { gettext } from "../kit/text.ts";
import type { Pose } from "../motion/chain.ts";
import { keys } from "../page/keys.ts";
import { printTask, type TaskStep } from "../widgets/task_text.ts";
import type { Recorded, Recorder } from "./recorder.ts";

/** The text of the task mode. */
export interface TaskText {
  /** Begin a new text where a saved one is shown. */
  fresh(): void;
  add(...steps: TaskStep[]): void;
  /** Take away the last lines, if they are these steps. */
  takeBack(...steps: TaskStep[]): void;
}
export interface RecordUse {
  pose(): Pose | null;
  /** Put the ghost there. */
  put(pose: Float64Array): void;
  /** The objects are shown elsewhere. */
  changed(): void;
  /** Move the ghost through these poses. Returns why it cannot; empty if it can. */
  play(poses: readonly Float64Array[]): string;
  /** Show the task mode. */
  edit(): void;
}

const IDLE = gettext("While you record, nothing is sent: take the ghost to a brick, grip, take it to its place, put it down.");

export class RecordPanel {
  private button = byId("record");
  private gripButton = byId("record-grip");

  constructor(
    private recorder: Recorder,
    private text: TaskText,
    private use: RecordUse,
  ) {
    byId("scene-record").hidden = false;
    this.button.addEventListener("click", () => this.toggle());
    const acts: Record<string, () => void> = { grip: () => this.grip(), way: () => this.way(), undo: () => this.undo() };
    for (const [name, act] of Object.entries({ ...acts, play: () => this.play() })) {
      const button = byId(`record-${name}`);
      button.addEventListener("click", () => (refusal(button) ? this.draw(refusal(button)) : act()));
    }
    byId("record-edit").addEventListener("click", () => use.edit());
    byId("ghost-hand").addEventListener("keydown", (event) => {
      const act = event.repeat ? undefined : acts[keys.action(event)];
      if (!act || !recorder.runs) return;
      event.preventDefault();
      act();
    });
    this.draw(IDLE);
  }

  private toggle(): void {
    if (this.recorder.runs) this.recorder.end();
    else {
      this.recorder.begin();
      this.text.fresh();
    }
    this.use.changed();
    this.draw(this.recorder.runs ? gettext("It records. The objects are shown where your task would have them.") : IDLE);
  }

  private grip(): void {
    const tool = this.use.pose(),
      made = tool && this.recorder.grip(tool);
    if (typeof made === "string") this.draw(made);
    else this.note(made);
  }

  private way(): void {
    const tool = this.use.pose();
    this.note(tool && this.recorder.move(tool));
  }

  private note(made: Recorded | null): void {
    if (!made) return this.draw(gettext("It is not known yet where the arm is."));
    this.text.add(...made.steps);
    this.use.put(made.pose);
    this.use.changed();
    this.draw(gettext("Recorded: {lines}.", { lines: printTask(made.steps).replace("\n", ", ") }));
  }

  private undo(): void {
    const undone = this.recorder.undo();
    if (undone) this.text.takeBack(...undone.steps);
    this.use.changed();
    this.draw(
      undone ? gettext("Taken back: {lines}.", { lines: printTask(undone.steps).replace("\n", ", ") }) : gettext("Nothing is recorded."),
    );
  }

  private play(): void {
    this.draw(this.use.play(this.recorder.poses) || gettext("The ghost shows the way from the arm."));
  }

  private draw(said: string): void {
    const { runs, steps, grips } = this.recorder;
    set(this.button, { "aria-pressed": String(runs) });
    say(this.gripButton, grips ? gettext("Put down") : gettext("Grip"));
    const idle = runs ? "" : gettext("Press Record first.");
    for (const name of ["grip", "way"]) allow(byId(`record-${name}`), idle);
    for (const name of ["undo", "play"]) allow(byId(`record-${name}`), steps.length ? "" : idle || gettext("Nothing is recorded."));
    sayLines(byId("record-list"), steps.length ? printTask(steps).split("\n") : []);
    say(byId("record-said"), said);
  }
}
