/** Records a task from the ghost: what it would grasp and put where, as steps, on a copy of the objects. Nothing is sent. */
import type { Pose } from "../motion/chain.ts";
import type { TaskStep } from "../widgets/task_text.ts";
import { distance, numbersOfPose } from "./moves.ts";
import type { SceneObjects } from "./objects.ts";
import { gettext, translate } from "../kit/text.ts";

export interface Recorded {
  steps: TaskStep[];
  /** The pose of the tool at which they begin or end. */
  pose: Float64Array;
}
const NEAR_M = 0.005, // the ghost is put exactly at a grasp that is no farther away
  NEAR_RAD = (5 * Math.PI) / 180;

export class Recorder {
  private made: { recorded: Recorded; before: ReturnType<SceneObjects["copy"]> }[] = [];
  private readonly objects: SceneObjects;

  constructor(objects: SceneObjects) {
    this.objects = objects;
  }

  get runs(): boolean {
    return this.objects.isCopied;
  }

  /** Whether the ghost holds something. */
  get grips(): boolean {
    return this.runs && this.objects.held !== null;
  }

  get steps(): TaskStep[] {
    return this.made.flatMap(({ recorded }) => recorded.steps);
  }

  /** The poses of the tool in turn. */
  get poses(): Float64Array[] {
    return this.made.map(({ recorded }) => recorded.pose);
  }

  /** Begin, with the objects as they are known now. */
  begin(): void {
    this.made = [];
    this.objects.restore(this.objects.copy());
  }

  /** End: the objects are shown as they are known again. */
  end(): void {
    this.objects.restore(null);
  }

  /**
   * Take the object at the ghost, or put down the one that it holds. Returns what was recorded, or why nothing was, as a
   * sentence.
   */
  grip(tool: Pose): Recorded | string {
    const { held } = this.objects;
    return held ? this.put(tool) : this.take(tool);
  }

  /** Record that the tool goes to where the ghost is. */
  move(tool: Pose): Recorded {
    const [x = 0, y = 0, z = 0, ...turn] = numbersOfPose(tool);
    const place = [x, y, z].map((v) => round(v * 1000)),
      angles = turn.map((v) => round((v * 180) / Math.PI));
    return this.note([{ do: "move", place, angles }], tool);
  }

  /** Take back the last record. Returns it; null if there is none. */
  undo(): Recorded | null {
    const last = this.made.pop();
    if (!last) return null;
    this.objects.restore(last.before);
    return last.recorded;
  }

  private take(tool: Pose): Recorded | string {
    const goal = this.objects.graspAt(tool),
      far = goal && distance(tool, goal.pose);
    if (!goal || far!.m > NEAR_M || far!.rad > NEAR_RAD)
      return gettext("Nothing is between the fingers of the ghost: put it at a grasp first.");
    const top = this.objects.above(goal.name);
    if (top) return gettext("{top} lies on {object}.", { top: translate(top), object: translate(goal.name) });
    const noted = this.note([{ do: "grasp", name: goal.name }], goal.pose);
    this.objects.hold(goal.name, goal.pose);
    return noted;
  }

  private put(tool: Pose): Recorded | string {
    const { held } = this.objects;
    if (!held) return "";
    const step = this.objects.stepAt(tool);
    if (!step) {
      if (!held.facts.hangs)
        return gettext("Nothing is beneath {object}, or it lies beside the studs: move the ghost to a place for it.", {
          object: translate(held.facts.name),
        });
      const moved = this.move(tool); // it may be let go anywhere, as on its threads
      moved.steps.push({ do: "open" });
      this.objects.release(tool);
      return moved;
    }
    const noted = this.note([step], tool);
    this.objects.release(tool);
    return noted;
  }

  private note(steps: TaskStep[], tool: Pose): Recorded {
    const recorded = { steps, pose: Float64Array.from({ length: 16 }, (_, i) => tool[i]!) };
    this.made.push({ recorded, before: this.objects.copy() });
    return recorded;
  }
}

function round(value: number): number {
  return Math.round(value * 10) / 10 || 0;
}
