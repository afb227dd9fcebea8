/** The live wire trace for staff. */
import { make } from "../kit/dom.ts";
import { every } from "../kit/page_clock.ts";
import { gettext } from "../kit/text.ts";
import type { TraceLine } from "../socket/messages.ts";

const KEEP = 200;

export class WireTrace {
  private count = 0;
  private since = performance.now();
  private bytes = 0;
  private resent = 0;
  private broken = 0;

  constructor(
    private box: HTMLElement,
    private rate: HTMLElement,
  ) {
    every(1000, () => this.tell());
  }

  add(line: TraceLine): void {
    const out = line.direction === ">";
    const hex = written(line.hex) === line.words ? [] : [make("code", {}, line.hex)];
    const direction = make("span", {}, out ? gettext("host → robot") : gettext("robot → host"));
    this.box.prepend(make("li", { class: out ? "out" : "in" }, direction, make("b", {}, line.words), ...hex));
    while (this.box.childElementCount > KEEP) this.box.lastElementChild?.remove();
    this.count += 1;
    this.bytes += (line.hex.length + 1) / 3;
    this.resent = line.resent;
    this.broken = line.broken;
  }

  private tell(): void {
    const seconds = (performance.now() - this.since) / 1000;
    const { resent, broken } = this,
      frames = (this.count / seconds).toFixed(1),
      bytes = (this.bytes / seconds).toFixed(0);
    this.rate.textContent = gettext("{frames} frames/s, {bytes} bytes/s, {resent} resent, {broken} broken frames heard", {
      frames,
      bytes,
      resent,
      broken,
    });
    if (seconds > 5) {
      this.since = performance.now();
      this.count = this.bytes = 0;
    }
  }
}

/** Return the bytes as text. */
function written(hex: string): string {
  return String.fromCharCode(...hex.split(" ").map((byte) => parseInt(byte, 16))).trim();
}
