/** What a robot's console consists of. */
import type { ShownPicture } from "../media/reduced_motion.ts";
import type { CommandInfo, Still } from "../socket/messages.ts";
import type { PicturePacket, StatePacket, StreamPacket } from "../socket/packets.ts";
import type { Facts } from "./controls.ts";

/** The part that differs between robots: the middle of the page. */
export interface Console {
  /** The socket is open (again): choose cameras if not only the first one is wanted. */
  watch?(): void;
  picture(packet: PicturePacket): void;
  /** `picture` takes those of video too, which have an `image` instead of a `jpeg`. */
  video?: boolean;
  state(packet: StatePacket): void;
  /** The next packet of a byte stream: a key packet holds everything, a delta what changed since the one before. */
  stream?(name: string, packet: StreamPacket): void;
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

/** What the defaults of a console ask of its page. */
export interface ConsolePage {
  draw(): void;
}
