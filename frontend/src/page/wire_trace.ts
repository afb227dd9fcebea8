/** The live wire trace for staff. */
import { every } from "../kit/page_clock.ts";
import type { TraceLine } from "../socket/messages.ts";

const KEEP = 200;

export class WireTrace {
  private count = 0;
  private since = performance.now();
  private bytes = 0;

  constructor(
    private box: HTMLElement,
    private rate: HTMLElement,
  ) {
    every(1000, () => this.tell());
  }

  private resent = 0;
  private broken = 0;

  add(line: TraceLine): void {
    const row = document.createElement("li");
    row.className = line.direction === ">" ? "out" : "in";
    const direction = document.createElement("span");
    direction.textContent = line.direction === ">" ? "host → robot" : "robot → host";
    const words = document.createElement("b");
    words.textContent = line.words;
    const hex = document.createElement("code");
    hex.textContent = line.hex;
    row.append(direction, words, ...(written(line.hex) === line.words ? [] : [hex]));
    this.box.prepend(row);
    while (this.box.childElementCount > KEEP) this.box.lastElementChild?.remove();
    this.count += 1;
    this.bytes += (line.hex.length + 1) / 3;
    this.resent = line.resent;
    this.broken = line.broken;
  }

  private tell(): void {
    const seconds = (performance.now() - this.since) / 1000;
    this.rate.textContent = `${(this.count / seconds).toFixed(1)} frames/s, ${(this.bytes / seconds).toFixed(0)} bytes/s, ${this.resent} resent, ${this.broken} broken frames heard`;
    if (seconds > 5) {
      this.since = performance.now();
      this.count = this.bytes = 0;
    }
  }
}

/** The text of the bytes, if the wire carries plain text. */
function written(hex: string): string {
  return String.fromCharCode(...hex.split(" ").map((byte) => parseInt(byte, 16))).trim();
}
