/** A terminal for the arm's own lines: each line becomes a command of the portal. */
import type { Judge } from "/static/farhand/v1/arm.js";
import { byId, type RobotPage } from "/static/farhand/v1/console.js";
import { understood } from "./terminal_lines.ts";
import { gettext, translate } from "/static/farhand/v1/text.js";

const LONGEST = 200;

export class Terminal {
  private list = byId("terminal-said");
  private last: string[] = [];
  private at = 0;

  constructor(
    private page: RobotPage,
    private console: Judge,
    private axes: string[],
  ) {
    const line = byId<HTMLInputElement>("terminal-line");
    byId<HTMLFormElement>("terminal").addEventListener("submit", (event) => {
      event.preventDefault();
      if (line.value.trim()) this.take(line.value.trim());
      line.value = "";
    });
    line.addEventListener("keydown", (event) => {
      const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      this.at = Math.min(this.last.length, Math.max(0, this.at + step));
      line.value = this.last[this.at] ?? "";
    });
  }

  private take(line: string): void {
    this.last.push(line);
    this.at = this.last.length;
    const asked = this.say(line, "said");
    const answer = (words: string): void => void this.say(words, "answer", asked);
    if (line === "h") {
      this.page.live.send({ t: "stop" });
      return answer(gettext("stop was sent; it stays until you release it"));
    }
    if (line === "w") {
      const { state } = this.page;
      const error = this.page.snapshot?.robot.state === "fault" || state?.mode.startsWith("RANGE");
      return answer(error ? "e" : state?.moving || this.page.facts().busy ? "b" : "a");
    }
    try {
      const target = understood(line, this.axes);
      const why = this.console.whyNot("terminal", this.page.facts());
      if (why) return answer(why);
      const seq = this.page.issue(target.kind, target.args);
      this.page.ladder.whenEnded(this.page.grant, seq, (c) =>
        answer(c.state === "completed" ? "ok" : `e ${translate(c.reason) || c.state}`),
      );
    } catch (error) {
      answer(`e ${translate((error as Error).message)}`);
    }
  }

  /** Show a line; an answer is shown below its line, whenever it arrives. */
  private say(words: string, kind: string, asked?: HTMLElement): HTMLElement {
    const item = document.createElement("p");
    item.className = kind;
    item.textContent = words;
    if (asked?.isConnected) asked.after(item);
    else this.list.append(item);
    while (this.list.children.length > LONGEST) this.list.firstElementChild?.remove();
    this.list.scrollTop = this.list.scrollHeight;
    return item;
  }
}
