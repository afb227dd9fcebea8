/** A robot's console: what it consists of, and defaults for the parts that it lacks. */
import { byId } from "../kit/dom.ts";
import { gettext } from "../kit/text.ts";
import { CameraView } from "../media/camera_view.ts";
import type { ShownPicture } from "../media/pictures.ts";
import type { CommandInfo, Still } from "../socket/messages.ts";
import type { PathPacket, PicturePacket, StatePacket, StreamPacket } from "../socket/packets.ts";
import { blocked, type Facts } from "./controls.ts";
import { configKinds } from "./facts.ts";
import { sayWord } from "./plain_words.ts";

/** The part that differs between robots: the middle of the page. */
export interface Console {
  /** The socket is open (again): choose cameras if not only the first one is wanted. */
  watch?(): void;
  picture(packet: PicturePacket): void;
  /** Whether `picture` also takes pictures of video, which have an `image` instead of a `jpeg`. */
  video?: boolean;
  state(packet: StatePacket): void;
  /** The next packet of a byte stream: a key packet holds everything, a delta what changed since the one before. */
  stream?(name: string, packet: StreamPacket): void;
  /** The robot begins to move on a path: its intention, which states may or may not confirm. */
  path?(packet: PathPacket): void;
  still(still: Still): void;
  /** A grant began or ended, or another one took its place. */
  turn(): void;
  command(command: CommandInfo): void;
  draw(facts: Facts): void;
  /** The line above the controls if nothing general prevents commands. */
  advice(facts: Facts): string;
  /** The picture of that camera that is shown now. */
  shown(camera: number): ShownPicture | undefined;
  /** When the picture on screen was taken, server ms; 0 for none. */
  pictureAt(): number;
  /** Why this kind of command does not work now; empty if it does. */
  whyNot(kind: string, facts: Facts): string;
}

/** What the defaults of a console need from its page. */
export interface ConsolePage {
  draw(): void;
}

/** The defaults of a console: the first camera is shown, one command at a time. */
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
    if (mode) sayWord(mode, packet.mode);
  }

  still(still: Still): void {
    this.camera.still(still, () => this.page.draw());
  }

  turn(): void {}

  command(_: CommandInfo): void {}

  draw(_: Facts): void {}

  advice(f: Facts): string {
    return f.busy ? gettext("The robot is busy.") : "";
  }

  shown(camera: number): CameraView | undefined {
    return camera === 0 ? this.camera : undefined;
  }

  pictureAt(): number {
    return this.camera.atMs;
  }

  whyNot(kind: string, f: Facts): string {
    return blocked(f) || (f.busy && !configKinds.has(kind) ? gettext("One command at a time: the robot is still busy.") : "");
  }
}

type Part = Exclude<keyof Console, "video" | "stream" | "path">;
const PARTS: Part[] = ["watch", "picture", "state", "still", "turn", "command", "draw", "advice", "shown", "pictureAt", "whyNot"];

/** Return a complete console: the members of `own`, and defaults for the rest. */
export function completeConsole(own: Partial<Console>, page: ConsolePage): Console {
  const whole: Record<string, unknown> = {};
  const basics: Partial<Console> = PARTS.every((part) => own[part]) ? {} : new Basics(page);
  for (const part of PARTS) {
    const from = own[part] ? own : basics;
    whole[part] = (from[part] as (...given: unknown[]) => unknown).bind(from);
  }
  whole["video"] = own.video ?? !own.picture; // a picture of its own may know JPEG alone
  if (own.stream) whole["stream"] = own.stream.bind(own);
  if (own.path) whole["path"] = own.path.bind(own);
  return whole as unknown as Console;
}
