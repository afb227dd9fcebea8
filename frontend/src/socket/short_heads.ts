/** Reads deltas of byte streams that come with a short head over a thin line (robots/kit/contract/short_heads.py). */
import type { Packet, StreamPacket } from "./packets.ts";

const HEAD = 4;
/** The first byte of a delta with a short head. */
export const SHORT = 9;

export class ShortHeads {
  private newest = new Map<number, StreamPacket>();

  /** Note a packet that has come over the socket, if it is of a byte stream. Returns it. */
  note(packet: Packet | null): Packet | null {
    if (packet && "data" in packet) this.newest.set(packet.stream, { ...packet, data: new Uint8Array(0) });
    return packet;
  }

  /** Return the packet of a delta with a short head, which is not noted; null if what it follows did not come. */
  take(data: ArrayBuffer): StreamPacket | null {
    if (data.byteLength < HEAD) return null;
    const view = new DataView(data),
      both = view.getUint8(1),
      stream = both >> 5,
      before = this.newest.get(stream),
      number = before ? (before.number + 1) >>> 0 : 0;
    if (!before || number % 32 !== both % 32) {
      this.newest.delete(stream);
      return null;
    }
    const atMs = before.atMs + view.getUint16(2, true);
    return { stream, key: false, run: before.run, number, atMs, data: new Uint8Array(data, HEAD) };
  }

  /** Forget all packets: another socket begins with whole heads. */
  clear(): void {
    this.newest.clear();
  }
}
