/** The order of a camera's video. */
import type { VideoPacket } from "../socket/packets.ts";

/** Which packets of a camera's video can be decoded: a key picture, then each picture that changes the one before it. */
export class VideoChain {
  private run = 0;
  private newest: number | null = null;

  /** Take a packet. Returns whether it can be decoded; if not, everything until the next key picture is left out. */
  take(packet: Pick<VideoPacket, "run" | "number" | "follows">): boolean {
    const follows = packet.follows === null || (packet.run === this.run && packet.follows === this.newest);
    this.run = packet.run;
    this.newest = follows ? packet.number : null;
    return follows;
  }

  forget(): void {
    this.newest = null;
  }
}
