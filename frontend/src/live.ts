/** The socket to a robot: opens, keeps itself alive, comes back with a jitter. */
import { decode, type Message, type PicturePacket, type StatePacket } from "./protocol.ts";

export interface Handlers {
  message(message: Message): void;
  state(packet: StatePacket): void;
  picture(packet: PicturePacket): void;
  line(up: boolean): void;
}

export class Live {
  /** Server time minus ours, ms. */
  offset = 0;
  latency: number | null = null;
  up = false;
  private socket: WebSocket | null = null;
  private tries = 0;
  private pings = new Map<number, number>();
  private count = 0;
  private heard = 0;

  constructor(private slug: string, private handlers: Handlers, private pingEvery: () => number) {
    this.open();
    this.beat();
    setInterval(() => this.watch(), 1000);
  }

  now(): number {
    return Date.now() + this.offset;
  }

  send(message: object): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  private open(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/ws/robots/${this.slug}/`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.tries = 0;
      this.heard = performance.now();
      this.set(true);
      this.ping();
    };
    socket.onmessage = (event) => this.receive(event.data as string | ArrayBuffer);
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.set(false);
      if (event.code === 4404) return;
      if (event.code === 4401 || event.code === 4403) this.handlers.message({ t: "notice", text: event.reason, level: "warning" });
      const pause = Math.min(8000, 400 * 2 ** this.tries++) * (0.5 + Math.random());
      setTimeout(() => this.open(), pause);
    };
  }

  private receive(data: string | ArrayBuffer): void {
    this.heard = performance.now();
    if (typeof data !== "string") {
      const packet = decode(data);
      if (packet === null) return;
      if ("jpeg" in packet) this.handlers.picture(packet);
      else this.handlers.state(packet);
      return;
    }
    const message = JSON.parse(data) as Message;
    if (message.t === "pong") {
      const sent = this.pings.get(message.n);
      this.pings.delete(message.n);
      if (sent !== undefined) {
        this.latency = performance.now() - sent;
        this.offset = message.now_ms + this.latency / 2 - Date.now();
      }
    } else if (message.t === "snapshot" && this.latency === null) {
      this.offset = message.now_ms - Date.now();
    }
    this.handlers.message(message);
  }

  private ping(): void {
    const n = ++this.count;
    this.pings.set(n, performance.now());
    if (this.pings.size > 20) this.pings.clear();
    this.send({ t: "ping", n });
  }

  private beat(): void {
    setTimeout(() => {
      this.ping();
      this.beat();
    }, this.pingEvery());
  }

  /** A line that has said nothing for long is dead even if the browser has not noticed. */
  private watch(): void {
    if (this.up && performance.now() - this.heard > this.pingEvery() + 5000) {
      const old = this.socket;
      this.socket = null;
      old?.close();
      this.set(false);
      this.open();
    }
  }

  private set(up: boolean): void {
    this.up = up;
    this.handlers.line(up);
  }
}
