/** Reads deltas of byte streams that come with a short head over a thin line (robots/kit/contract/short_heads.py). */
import type { Packet, StreamPacket } from "./packets.ts";

const HEAD = 3,
  FIRST = 16, // the first byte, of stream 0
  STREAMS = 8,
  NUMBERS = 2 ** 4,
  LATER_MS = 2 ** 12;

/** Return whether a message with that first byte is a delta with a short head. */
export function isShort(first: number | undefined): boolean {
  return first !== undefined && first >= FIRST && first < FIRST + STREAMS;
}

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
      stream = view.getUint8(0) - FIRST,
      both = view.getUint16(1, true),
      before = this.newest.get(stream),
      number = before ? (before.number + 1) >>> 0 : 0;
    if (!before || number % NUMBERS !== Math.floor(both / LATER_MS)) {
      this.newest.delete(stream);
      return null;
    }
    const atMs = before.atMs + (both % LATER_MS);
    return { stream, key: false, run: before.run, number, atMs, data: new Uint8Array(data, HEAD) };
  }

  /** Forget all packets: another socket begins with whole heads. */
  clear(): void {
    this.newest.clear();
  }
}
