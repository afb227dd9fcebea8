/** Video of cameras, decoded by the browser (WebCodecs) where it can; where it cannot, pictures come as JPEG. */
import type { Coding, PicturePacket, VideoPacket } from "../socket/packets.ts";
import { VideoChain } from "./video_chain.ts";

/** The codings of live video, as WebCodecs names them: VP9 of profile 0 and level 1, with 8 bits. */
const CODECS: Record<Coding, string> = { vp8: "vp8", vp9: "vp09.00.10.08" };
/** Levels are of the full range, colours by ITU-R BT.601; VP8 itself carries neither. */
const config = (coding: Coding): VideoDecoderConfig => ({
  codec: CODECS[coding],
  optimizeForLatency: true,
  colorSpace: { primaries: "smpte170m", transfer: "smpte170m", matrix: "smpte170m", fullRange: true },
});
const OVERDUE_MS = 2000; // the decoder does not work if a picture waits for so long
const IDLE_MS = 5000; // without a packet for so long the decoder is closed
const CHECK_MS = 500,
  LATE_MS = 1000; // after so long without a check the page did not run, and a check says nothing
const AGAIN_MS = 60_000,
  TRIES = 3; // the pause after a failure, and the number of attempts in all
const SHOWN_MS = 200; // while newer ones wait, a picture is shown only so often
const NONE = new Blob();

/** The decoder of one camera. */
class CameraDecoder {
  private chain = new VideoChain();
  private decoder: VideoDecoder | null = null;
  private waiting = new Map<number, { packet: VideoPacket; since: number }>(); // in the decoder, by number
  private shownAt = 0;
  private heardAt = 0; // a packet

  constructor(
    private coding: Coding,
    private show: (picture: PicturePacket) => void,
    private failed: () => void,
  ) {}

  take(packet: VideoPacket): void {
    this.heardAt = performance.now();
    if (!this.chain.take(packet)) return;
    this.decoder ??= this.open();
    this.waiting.set(packet.number, { packet, since: performance.now() });
    const type = packet.follows === null ? "key" : "delta";
    this.decoder.decode(new EncodedVideoChunk({ type, timestamp: packet.number, data: packet.coded }));
  }

  private open(): VideoDecoder {
    const decoder = new VideoDecoder({ output: (frame) => this.decoded(frame), error: () => this.failed() });
    decoder.configure(config(this.coding));
    return decoder;
  }

  private decoded(frame: VideoFrame): void {
    try {
      this.pass(frame);
    } finally {
      frame.close();
    }
  }

  private pass(frame: VideoFrame): void {
    const packet = this.waiting.get(frame.timestamp)?.packet;
    this.waiting.delete(frame.timestamp);
    const now = performance.now();
    if (!frame.colorSpace.fullRange)
      this.failed(); // it would look pale
    else if (packet && (this.waiting.size === 0 || now - this.shownAt > SHOWN_MS)) {
      this.shownAt = now;
      const { camera, number, atMs, still } = packet;
      this.show({ camera, number, atMs, still, joints: [], jpeg: NONE, image: frame });
    }
  }

  /** Whether nothing has come for a while. */
  get idle(): boolean {
    return performance.now() - this.heardAt > IDLE_MS;
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

export class VideoPlayer {
  private decoders = new Map<number, CameraDecoder>();
  private broken = false;
  private failures = 0;
  private checkedAt = performance.now();

  /** `show` gets each decoded picture; `works(false)` is called when this browser turns out not to decode them. */
  constructor(
    private coding: Coding,
    private show: (picture: PicturePacket) => void,
    private works: (on: boolean) => void,
  ) {
    document.addEventListener("visibilitychange", () => document.hidden && this.rest());
    setInterval(() => this.check(), CHECK_MS);
  }

  /** Resolve to whether this browser can decode that coding; only pages over https or of this machine may use WebCodecs. */
  static async possible(coding: Coding): Promise<boolean> {
    if (!("VideoDecoder" in globalThis)) return false;
    try {
      return (await VideoDecoder.isConfigSupported(config(coding))).supported === true;
    } catch {
      return false;
    }
  }

  /** Decode the next packet, unless nobody sees the page. */
  take(packet: VideoPacket): void {
    if (this.broken || document.hidden) return;
    try {
      this.decoder(packet.camera).take(packet);
    } catch {
      this.fail();
    }
  }

  /** Stop decoding until the next key picture. */
  rest(): void {
    for (const decoder of this.decoders.values()) decoder.close();
  }

  private decoder(camera: number): CameraDecoder {
    let decoder = this.decoders.get(camera);
    if (!decoder) {
      decoder = new CameraDecoder(this.coding, this.show, () => this.fail());
      this.decoders.set(camera, decoder);
    }
    return decoder;
  }

  private check(): void {
    const now = performance.now(),
      late = now - this.checkedAt > LATE_MS;
    this.checkedAt = now;
    if (late || document.hidden) return;
    if ([...this.decoders.values()].some((decoder) => decoder.overdue)) this.fail();
    for (const [camera, decoder] of this.decoders)
      if (decoder.idle) {
        decoder.close();
        this.decoders.delete(camera);
      }
  }

  private fail(): void {
    if (this.broken) return;
    this.broken = true;
    this.failures += 1;
    this.rest();
    this.works(false);
    if (this.failures < TRIES) setTimeout(() => this.retry(), AGAIN_MS);
  }

  private retry(): void {
    this.broken = false;
    this.works(true);
  }
}
