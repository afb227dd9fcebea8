/** The packets of a recording, read in slices of a few seconds when they are needed. */
import { FILE_MS, request } from "../kit/request.ts";
import { decode } from "../socket/decoder.ts";
import type { PicturePacket, StatePacket, StreamPacket } from "../socket/packets.ts";

const SLICE_MS = 5000;
const HEAD = 8;
const KEPT = 24; // the most slices in memory
const AT_ONCE = 4; // the most slices that are loaded at once

/** A packet, and when it arrived (ms since the beginning). */
export interface Item {
  at: number;
  packet: StatePacket | PicturePacket | StreamPacket;
}
/** A moment: the newest state, the newest picture of each camera, and the chain of each byte stream. */
interface Moment {
  state: Item | null;
  pictures: Map<number, Item>;
  chains: Map<number, Item[]>;
}

/** Return the packets of a slice, without those that cannot be decoded. */
export function unpackSlice(data: ArrayBuffer): Item[] {
  const view = new DataView(data),
    items: Item[] = [];
  for (let at = 0; at + HEAD <= data.byteLength;) {
    const length = view.getUint32(at, true),
      ms = view.getUint32(at + 4, true),
      end = at + HEAD + length;
    if (end > data.byteLength) break;
    const packet = decode(data.slice(at + HEAD, end));
    const recorded = packet && !("coded" in packet) && !("opus" in packet) && !("knots" in packet);
    if (recorded) items.push({ at: ms, packet }); // recordings hold whole pictures, no sound, and what was measured alone
    at = end;
  }
  return items;
}

/** Return what was known at a moment; `items` reach back far enough. Before its first picture a camera shows that one. */
export function momentOf(items: readonly Item[], at: number): Moment {
  const moment: Moment = { state: null, pictures: new Map(), chains: new Map() };
  for (const item of items) {
    const { packet } = item,
      late = item.at > at;
    if ("jpeg" in packet) {
      if (!late || !moment.pictures.has(packet.camera)) moment.pictures.set(packet.camera, item);
    } else if (late) {
      if (!("data" in packet)) moment.state ??= item;
    } else if ("data" in packet) {
      if (packet.key) moment.chains.set(packet.stream, [item]);
      else moment.chains.get(packet.stream)?.push(item);
    } else moment.state = item;
  }
  return moment;
}

export class Slices {
  private kept = new Map<number, Promise<Item[]>>();
  private ready = new Map<number, Item[]>();
  private address: string;
  private needs: readonly number[];

  /** `needs`: for each slice the earliest one that has to be read with it. */
  constructor(address: string, needs: readonly number[]) {
    this.address = address;
    this.needs = needs;
  }

  /** Return the number of the slice that contains a moment. */
  of(at: number): number {
    return Math.min(this.needs.length - 1, Math.max(0, Math.floor(at / SLICE_MS)));
  }

  /** Return the items of a slice if they are loaded. */
  now(number: number): Item[] | undefined {
    return this.ready.get(number);
  }

  /** Load a slice; beyond the end there are no items. */
  async read(number: number): Promise<Item[]> {
    if (number >= this.needs.length) return [];
    let reading = this.kept.get(number);
    if (!reading) {
      reading = this.fetched(number);
      this.kept.set(number, reading);
      reading.catch(() => this.kept.delete(number));
    }
    return reading;
  }

  /** Load everything that is needed to show a moment. */
  async until(at: number): Promise<Item[]> {
    const last = this.of(at),
      first = this.needs[last] ?? last;
    const parts: Item[][] = [];
    let next = first;
    const reader = async (): Promise<void> => {
      while (next <= last) {
        const number = next++;
        parts[number - first] = await this.read(number);
      }
    };
    await Promise.all(Array.from({ length: AT_ONCE }, reader));
    return parts.flat();
  }

  private async fetched(number: number): Promise<Item[]> {
    const answer = await request(`${this.address}${number}.bin`, {}, FILE_MS);
    if (!answer.ok) throw new Error(`slice ${number}: ${answer.status}`);
    const items = unpackSlice(await answer.arrayBuffer());
    this.ready.set(number, items);
    for (const old of this.ready.keys())
      if (this.ready.size > KEPT && old !== number) {
        this.ready.delete(old);
        this.kept.delete(old);
      }
    return items;
  }
}
