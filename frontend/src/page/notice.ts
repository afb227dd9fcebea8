/** The page's short messages. A refusal disappears as soon as its reason is gone. */
import { say } from "../kit/dom.ts";

const INFO_MS = 6000,
  WARNING_MS = 12_000; // how long one is shown
const LEAST_MS = 3000; // a refusal stays at least so long, so that it can be read

export class Notice {
  private readonly box: HTMLElement;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private refused: (() => string) | null = null;
  private since = 0;
  private holds: (() => boolean) | undefined;

  constructor(box: HTMLElement) {
    this.box = box;
  }

  /** Show a message. `holds` is called again and again; the message disappears when it returns false. */
  show(words: string, level: string, holds?: () => boolean): void {
    this.refused = null;
    this.holds = holds;
    this.since = performance.now();
    say(this.box, words);
    this.box.className = `notice ${level}`;
    this.box.hidden = false;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.hide(), level === "info" ? INFO_MS : WARNING_MS);
  }

  /** Show why something was refused. `why` is called again and again, and returns an empty text once the reason is gone. */
  refuse(why: () => string): void {
    this.show(why(), "warning");
    this.refused = why;
  }

  hide(): void {
    this.box.hidden = true;
    this.refused = null;
    this.holds = undefined;
  }

  /** Hide a refusal: the person has chosen something else, or sent a command. */
  settle(): void {
    if (this.refused) this.hide();
  }

  /** Hide a message that is no longer true; called again and again. */
  draw(): void {
    if (this.holds?.() === false) this.hide();
    if (this.refused && performance.now() - this.since > LEAST_MS && this.refused() !== this.box.textContent) this.hide();
  }
}
