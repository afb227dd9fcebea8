/** The defaults of a console: the first camera is shown, one command at a time. */
import { byId, say } from "../kit/dom.ts";
import { CameraView } from "../media/camera_view.ts";
import type { CommandInfo, Still } from "../socket/messages.ts";
import type { PicturePacket, StatePacket } from "../socket/packets.ts";
import type { Console, ConsolePage } from "./console.ts";
import { blocked, type Facts } from "./controls.ts";
import { configKinds } from "./facts.ts";

export class Basics<Page extends ConsolePage = ConsolePage> implements Console {
  readonly video = true;
  protected camera: CameraView;

  constructor(
    protected page: Page,
    camera?: CameraView,
  ) {
    this.camera = camera ?? new CameraView(byId("screen"), byId<HTMLCanvasElement>("picture"), null, () => undefined);
  }

  watch(): void {}

  picture(packet: PicturePacket): void {
    if (packet.camera === 0) void this.camera.show(packet).then(() => this.page.draw());
  }

  state(packet: StatePacket): void {
    const mode = document.getElementById("mode");
    if (mode) say(mode, packet.mode);
  }

  still(still: Still): void {
    this.camera.still(still, () => this.page.draw());
  }

  turn(): void {}

  command(_: CommandInfo): void {}

  draw(_: Facts): void {}

  advice(f: Facts): string {
    return f.busy ? "The robot is busy." : "";
  }

  shown(camera: number): CameraView | undefined {
    return camera === 0 ? this.camera : undefined;
  }

  pictureAt(): number {
    return this.camera.atMs;
  }

  whyNot(kind: string, f: Facts): string {
    return blocked(f) || (f.busy && !configKinds.has(kind) ? "One command at a time: the robot is still busy." : "");
  }
}

const PARTS = [
  "watch",
  "picture",
  "state",
  "still",
  "turn",
  "command",
  "draw",
  "advice",
  "shown",
  "pictureAt",
  "whyNot",
] as const satisfies readonly (keyof Console)[];

/** A complete console: the members of `own`, and defaults for the rest. */
export function completeConsole(own: Partial<Console>, page: ConsolePage): Console {
  const whole: Record<string, unknown> = {};
  const basics: Partial<Console> = PARTS.every((part) => own[part]) ? {} : new Basics(page);
  for (const part of PARTS) {
    const from = own[part] ? own : basics;
    whole[part] = (from[part] as (...given: unknown[]) => unknown).bind(from);
  }
  whole["video"] = own.video ?? !own.picture; // a picture of its own may know JPEG alone
  if (own.stream) whole["stream"] = own.stream.bind(own);
  return whole as unknown as Console;
}
