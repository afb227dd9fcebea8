/** Stop and its release: the buttons, the keys, and a press until it is known to have arrived. */
import { byId } from "../kit/dom.ts";
import type { Connection } from "../socket/connection.ts";
import type { Snapshot } from "../socket/messages.ts";
import { STOP } from "../kit/keys.ts";
import { keys } from "./keys.ts";
import { StopPress } from "./stop_press.ts";

/** The parts of the page that `StopButton` needs. */
interface StopUse {
  connection: Connection;
  /** Run `act` at a press of the buttons with that name. */
  on(name: string, act: () => void): void;
  notice(words: string, level: string): void;
  snapshot(): Snapshot | null;
  draw(): void;
}

export class StopButton {
  readonly press: StopPress;
  private checked = byId<HTMLInputElement>("checked");

  constructor(private use: StopUse) {
    this.press = new StopPress(use.connection, (words, level) => use.notice(words, level));
    use.on("stop", () => this.stop());
    use.on("release", () => use.connection.send({ t: "release", checked: this.checked.checked }));
    byId("stage").addEventListener("keydown", (event) => this.key(event));
  }

  /** Whether the person has confirmed that they looked at the robot. */
  get looked(): boolean {
    return this.checked.checked;
  }

  private key(event: KeyboardEvent): void {
    const field = (event.target as HTMLElement).closest("input, textarea, select, [contenteditable]");
    if (event.repeat || keys.action(event) !== STOP || !this.use.snapshot()?.me.can.stop) return;
    if (field && event.key !== "Escape") return;
    event.preventDefault();
    this.stop();
  }

  private stop(): void {
    this.press.press();
    this.use.draw();
  }
}
