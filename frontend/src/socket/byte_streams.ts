/** The byte streams of a robot: the newest key packet of each, and the deltas after it. */
import type { StreamPacket } from "./packets.ts";

export class ByteStreams {
  private chains = new Map<number, StreamPacket[]>();
  private names: string[];

  constructor(names: string[]) {
    this.names = names;
  }

  /** Take a packet. Returns the name of its stream; undefined for a delta that does not follow the last packet. */
  take(packet: StreamPacket): string | undefined {
    const chain = this.chains.get(packet.stream),
      last = chain?.at(-1);
    if (packet.key) this.chains.set(packet.stream, [packet]);
    else if (chain && last && packet.run === last.run && packet.number === (last.number + 1) >>> 0) chain.push(packet);
    else return undefined;
    return this.names[packet.stream];
  }

  /** Return the newest key packet of that stream and the deltas after it; empty before the first. */
  of(name: string): StreamPacket[] {
    return [...(this.chains.get(this.names.indexOf(name)) ?? [])];
  }
}
