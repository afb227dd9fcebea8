/** Video of cameras, decoded by the browser (WebCodecs) where it can; where it cannot, pictures come as JPEG. */
import type { PicturePacket, VideoPacket } from "./protocol.ts";
import { Chain } from "./video_chain.ts";

export const CODING = "vp8";
/** Levels are of the full range, colours by ITU-R BT.601, which VP8 itself does not tell. */
const CONFIG: VideoDecoderConfig = {
  codec: CODING, optimizeForLatency: true,
  colorSpace: { primaries: "smpte170m", transfer: "smpte170m", matrix: "smpte170m", fullRange: true },
};
const OVERDUE_MS = 2000; // a picture that is not decoded for so long: the decoder does not work
const SHOWN_MS = 200; // while newer ones wait, a picture is shown only so often
const NONE = new Blob();

/** The decoder of one camera. */
class Reel {
  private chain = new Chain();
  private decoder: VideoDecoder | null = null;
  private waiting = new Map<number, { packet: VideoPacket; since: number }>(); // in the decoder, by number
  private shownAt = 0;

  constructor(private show: (picture: PicturePacket) => void, private failed: () => void) {}

  take(packet: VideoPacket): void {
    if (!this.chain.take(packet)) return;
    this.decoder ??= this.open();
    this.waiting.set(packet.number, { packet, since: performance.now() });
    const type = packet.follows === null ? "key" : "delta";
    this.decoder.decode(new EncodedVideoChunk({ type, timestamp: packet.number, data: packet.vp8 }));
  }

  private open(): VideoDecoder {
    const decoder = new VideoDecoder({ output: (frame) => this.decoded(frame), error: () => this.failed() });
    decoder.configure(CONFIG);
    return decoder;
  }

  private decoded(frame: VideoFrame): void {
    const packet = this.waiting.get(frame.timestamp)?.packet;
    this.waiting.delete(frame.timestamp);
    const now = performance.now();
    if (!frame.colorSpace.fullRange) this.failed(); // it would look pale
    else if (packet && (this.waiting.size === 0 || now - this.shownAt > SHOWN_MS)) {
      this.shownAt = now;
      const { camera, number, atMs, still } = packet;
      this.show({ camera, number, atMs, still, joints: [], jpeg: NONE, image: frame });
    }
    frame.close();
  }

  /** Whether a picture waits for too long. */
  get overdue(): boolean {
    const [oldest] = this.waiting.values();
    return oldest !== undefined && performance.now() - oldest.since > OVERDUE_MS;
  }

  close(): void {
    if (this.decoder && this.decoder.state !== "closed") this.decoder.close();
    this.decoder = null;
    this.waiting.clear();
    this.chain.forget();
  }
}

export class Film {
  private reels = new Map<number, Reel>();
  private broken = false;

  /** `show` gets each decoded picture; `failed` is called once, when this browser turns out not to decode them. */
  constructor(private show: (picture: PicturePacket) => void, private failed: () => void) {
    document.addEventListener("visibilitychange", () => document.hidden && this.rest());
    setInterval(() => this.check(), 500);
  }

  /** Whether this browser says that it decodes what comes; only pages over https or of this very machine may. */
  static async possible(): Promise<boolean> {
    if (!("VideoDecoder" in globalThis)) return false;
    try {
      return (await VideoDecoder.isConfigSupported(CONFIG)).supported === true;
    } catch {
      return false;
    }
  }

  /** Decode the next packet; nothing in a tab that nobody sees. */
  take(packet: VideoPacket): void {
    if (this.broken || document.hidden) return;
    try {
      this.reel(packet.camera).take(packet);
    } catch {
      this.fail();
    }
  }

  /** Decode no more until the next key picture. */
  rest(): void {
    for (const reel of this.reels.values()) reel.close();
  }

  private reel(camera: number): Reel {
    const reel = this.reels.get(camera) ?? new Reel((picture) => this.show(picture), () => this.fail());
    this.reels.set(camera, reel);
    return reel;
  }

  private check(): void {
    if (!document.hidden && [...this.reels.values()].some((reel) => reel.overdue)) this.fail();
  }

  private fail(): void {
    if (this.broken) return;
    this.broken = true;
    this.rest();
    this.failed();
  }
}
