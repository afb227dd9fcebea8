/** Plays a recording: gives a page what was recorded as if it came from the robot now. */
import type { PicturePacket } from "../socket/packets.ts";
import type { Handlers } from "../socket/robot_socket.ts";
import { type Item, momentOf, Slices } from "./slices.ts";
import type { Index, Story } from "./story.ts";

export class Player {
  /** ms since the beginning. */
  at = 0;
  playing = false;
  speed = 1;
  /** Whether a slice is awaited. */
  waiting = false;
  readonly length: number;
  private slices: Slices;
  private cameras: ReadonlySet<number> = new Set([0]);
  private handlers: Handlers | null = null;
  private count = 0;
  private seeks = 0;
  private ticked = 0;
  private stopped = false;

  /** `changed` is called when what is shown, or whether it plays, has changed; `failed` when a slice cannot be read. */
  constructor(
    private index: Index,
    address: string,
    private story: Story,
    private changed: () => void,
    private failed: () => void,
  ) {
    this.slices = new Slices(address, index.needs);
    this.length = Math.max(0, index.ended_ms - index.began_ms);
  }

  /** Begin to give everything to this page. */
  attach(handlers: Handlers): void {
    this.handlers = handlers;
    void this.seek(0);
    setInterval(() => this.tick(), 50);
  }

  now(): number {
    return this.index.began_ms + this.at;
  }

  /** Take a message of the page; only its choice of cameras matters. Returns whether it was that. */
  send(message: object): boolean {
    const wish = message as { t: string; cameras?: number[] };
    if (wish.t !== "watch" || !wish.cameras) return false;
    this.cameras = new Set(wish.cameras);
    if (this.handlers) void this.seek(this.at);
    return true;
  }

  play(on: boolean): void {
    if (on && this.at >= this.length) void this.seek(0);
    this.playing = on;
    this.ticked = performance.now();
    this.changed();
  }

  /** Show the moment `at` (ms since the beginning); of several calls the last one counts. */
  async seek(at: number): Promise<void> {
    const seek = ++this.seeks;
    this.at = Math.min(this.length, Math.max(0, at));
    this.waiting = true;
    this.changed();
    let items: Item[];
    try {
      items = await this.slices.until(this.at);
    } catch {
      if (seek === this.seeks) this.fail();
      return;
    }
    if (seek !== this.seeks) return;
    this.waiting = false;
    const moment = momentOf(items, this.at),
      { state } = moment;
    this.stopped = state !== null && "stopped" in state.packet && state.packet.stopped;
    this.handlers?.message(this.story.snapshot(this.at, this.stopped));
    if (state) this.give(state);
    for (const chain of moment.chains.values()) for (const item of chain) this.give(item);
    for (const item of moment.pictures.values()) this.give(item, true);
    this.ticked = performance.now();
    this.changed();
  }

  private fail(): void {
    this.waiting = this.playing = false;
    this.failed();
    this.changed();
  }

  private tick(): void {
    if (!this.playing || this.waiting) return;
    const now = performance.now(),
      from = this.at;
    const to = Math.min(this.length, from + (now - this.ticked) * this.speed);
    this.ticked = now;
    const slice = this.slices.of(to),
      items = this.here(from, to);
    if (!items) return void this.seek(from); // it waits for the slice, then shows the moment
    void this.slices.read(slice + 1).catch(() => undefined);
    this.at = to;
    const pictures = new Map<number, Item>();
    for (const item of items) {
      if ("jpeg" in item.packet) pictures.set(item.packet.camera, item);
      else this.give(item);
    }
    for (const item of pictures.values()) this.give(item);
    const { commands, events } = this.story.between(from, to);
    for (const command of commands) this.handlers?.message({ ...command, t: "command" });
    for (const { text, level } of events) this.handlers?.message({ t: "notice", text, level });
    if (to >= this.length) this.playing = false;
    this.changed();
  }

  /** Return the items between two moments; undefined if they are not all loaded. */
  private here(from: number, to: number): Item[] | undefined {
    const found: Item[] = [];
    for (let number = this.slices.of(from); number <= this.slices.of(to); number += 1) {
      const items = this.slices.now(number);
      if (!items) {
        void this.slices.read(number).catch(() => undefined);
        return undefined;
      }
      found.push(...items.filter(({ at }) => at > from && at <= to));
    }
    return found;
  }

  /** Give a packet to the page. `first`: whether it is a picture after a jump in time. */
  private give({ packet }: Item, first = false): void {
    if ("jpeg" in packet) {
      if (this.cameras.has(packet.camera)) this.handlers?.picture(this.numbered(packet, first));
    } else if ("data" in packet) this.handlers?.stream?.(packet);
    else this.handlers?.state(packet);
  }

  /** Pictures are numbered as they are shown: consoles drop what seems older. */
  private numbered(packet: PicturePacket, first: boolean): PicturePacket {
    return { ...packet, number: ++this.count, first };
  }
}
