/** The page's short messages. One that says why something was refused goes as soon as that is no longer so. */
import { say } from "../kit/dom.ts";

const INFO_MS = 6000,
  WARNING_MS = 12_000; // how long one is shown
const LEAST_MS = 3000; // a refusal can be read, whatever happens by itself meanwhile

export class Notice {
  private readonly box: HTMLElement;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private refused: (() => string) | null = null;
  private since = 0;
  private holds: (() => boolean) | undefined;

  constructor(box: HTMLElement) {
    this.box = box;
  }

  /** `holds`: whether the words still say something new; asked again and again. */
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

  /** Say why something was refused; `why` is asked again, and is empty when it would not be refused any more. */
  refuse(why: () => string): void {
    this.show(why(), "warning");
    this.refused = why;
  }

  hide(): void {
    this.box.hidden = true;
    this.refused = null;
    this.holds = undefined;
  }

  /** Something else was chosen or given: what was refused before is over. */
  settle(): void {
    if (this.refused) this.hide();
  }

  /** Called again and again. */
  draw(): void {
    if (this.holds?.() === false) this.hide();
    if (this.refused && performance.now() - this.since > LEAST_MS && this.refused() !== this.box.textContent) this.hide();
  }
}
