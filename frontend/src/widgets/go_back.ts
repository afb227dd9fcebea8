/** The control that chooses the place where the robot was before its last move; it is shown, and sent, as every target. */
import { byId } from "../kit/dom.ts";
import { allow } from "../kit/refusal.ts";
import { keys } from "../page/keys.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { WayBack } from "../page/way_back.ts";

/** What a console tells of its moves. */
export interface GoBackUse {
  /** The kinds of commands that move to a position. */
  kinds: readonly string[];
  /** How many of the robot's joints, from the first on, say where it is; or what else does, empty while it is not known. */
  joints: number | (() => readonly number[]);
  /** Why no target can be chosen now; empty if one can. */
  whyNot(): string;
  /** Choose the place with these joints (rad, m), or what `joints` returned, as the target; a move of `kind` left it. */
  choose(joints: readonly number[], kind: string): void;
}

const NEAR = 0.002; // rad, m: a joint this near is there
const ACTION = "go-back";
const FIELDS = "input, textarea, select, [contenteditable], .blocks";

export class GoBack {
  private way: WayBack;

  /** It acts on the buttons `data-command="go-back"` and on the key of that action. */
  constructor(
    private page: RobotPage,
    private use: GoBackUse,
  ) {
    const { kinds, joints } = use;
    this.way = page.wayBack(kinds, typeof joints === "number" ? () => page.state?.joints.slice(0, joints) ?? [] : joints);
    page.on(ACTION, () => this.choose());
    byId("stage").addEventListener("keydown", (event) => {
      if (event.repeat || keys.action(event) !== ACTION || (event.target as HTMLElement).closest(FIELDS) || !page.operating) return;
      event.preventDefault();
      this.choose();
    });
  }

  private whyNot(): string {
    return this.use.whyNot() || this.way.whyNot(NEAR);
  }

  private choose(): void {
    const { joints, kind } = this.way;
    if (joints && !this.whyNot()) this.use.choose(joints, kind);
    else this.page.refuse(() => this.whyNot());
  }

  /** Enable the buttons, or disable them with a reason. */
  draw(): void {
    const why = this.whyNot();
    for (const button of document.querySelectorAll<HTMLElement>(`[data-command="${ACTION}"]`)) allow(button, why);
  }
}
