/** The socket to a robot: opens, sends keep-alives, connects again after a random pause. */
import { openSocket } from "../kit/request.ts";
import type { CompactLayout } from "./compact_state.ts";
import { decode } from "./decoder.ts";
import type { Message } from "./messages.ts";
import { STREAM_OVER, OperatorStream } from "./operator_stream.ts";
import type { PathPacket, PicturePacket, SoundPacket, StatePacket, StreamPacket, VideoPacket } from "./packets.ts";
import { type Data, Outgoing } from "./outgoing.ts";
import { PIECE, Pieces, TEXT_PIECE, TextPieces } from "./pieces.ts";
import { RoundTrip } from "./round_trip.ts";
import { isShort, ShortHeads } from "./short_heads.ts";

export interface Handlers {
  message(message: Message): void;
  state(packet: StatePacket): void;
  picture(packet: PicturePacket): void;
  stream?(packet: StreamPacket): void;
  video?(packet: VideoPacket): void;
  sound?(packet: SoundPacket): void;
  path?(packet: PathPacket): void;
  line(up: boolean): void;
  /** A message of so many bytes has come. */
  took?(bytes: number): void;
  /** Whether another socket must not take over now: something runs that belongs to this one. */
  busy?(): boolean;
}

const PROBE_MS = 2000; // after this long without a message a ping is sent
const DOUBT_MS = 1000; // after this long without an answer the connection counts as lost
const FULL = 4503, // the close code for too many viewers, and the pause before the next attempt
  FULL_MS = 20_000;
const DEAD_MS = 6000,
  SPREAD_MS = 3000; // after this long, and a random part of that, another socket is opened
const WOKEN_MS = 3000; // the same for a page that did not run meanwhile
const HOPELESS = 2; // after so many failed attempts the operator's stream is opened without the public socket
const DRAIN_MS = 3000; // how long the socket before is read for answers to earlier requests
const ANSWER = '{"t": "answer"';
const NOTHING = '{"t":"watch","cameras":[],"compact":true}';

function firstByte(data: ArrayBuffer): number | undefined {
  return new Uint8Array(data)[0];
}

export class RobotSocket {
  up = false;
  /** The number of sockets opened so far; it tells into which one a message went. */
  opened = 0;
  private readonly slug: string;
  private readonly handlers: Handlers;
  private readonly pingEvery: () => number;
  private readonly layout: CompactLayout | null;
  private readonly wish: ((moved: boolean) => object) | null;
  private readonly pack: (message: object) => Uint8Array<ArrayBuffer> | null;
  private readonly outgoing: Outgoing;
  private socket: WebSocket | null = null;
  private tries = 0;
  private retry = 0;
  private full = false; // too many viewers: the next attempt keeps its pause
  private readonly roundTrip = new RoundTrip();
  private readonly pieces = new Pieces();
  private readonly texts = new TextPieces();
  private readonly heads = new ShortHeads();
  private heard = 0;
  private downAt = performance.now();
  private doubted = 0;
  private deadAfter = DEAD_MS; // random with each doubt, because a process that falls silent has many pages
  private probeAfter = PROBE_MS;
  private own: OperatorStream;
  private adopted: WebSocket | null = null; // the operator's stream, once it is the socket
  private none = false; // there is no such robot
  private known = false; // a snapshot has come over this socket
  private plan: object | null = null; // a request for a preview without an answer yet, sent or not

  /**
   * `wish` returns the `watch` message for a new socket; `moved`: the connection worked, and another socket takes over.
   * `pack` returns a message in few bytes, null if it is sent as JSON. `thin`: little may be on the way.
   */
  constructor(
    slug: string,
    handlers: Handlers,
    pingEvery: () => number,
    layout: CompactLayout | null = null,
    wish: ((moved: boolean) => object) | null = null,
    pack: (message: object) => Uint8Array<ArrayBuffer> | null = () => null,
    thin: () => boolean = () => false,
  ) {
    [this.slug, this.handlers, this.pingEvery, this.layout, this.wish, this.pack] = [slug, handlers, pingEvery, layout, wish, pack];
    this.outgoing = new Outgoing({ write: (data: Data) => this.socket?.send(data), ping: () => this.ping(), best: () => this.best, thin });
    this.own = new OperatorStream(slug, document.querySelector<HTMLInputElement>("[name=csrfmiddlewaretoken]")?.value ?? "");
    this.open();
    this.beat();
    setInterval(() => this.watch(), 250);
    addEventListener("offline", () => this.probe());
    addEventListener("online", () => (this.up ? this.probe() : this.full || this.open()));
    addEventListener("pageshow", ({ persisted }) => persisted && this.wake());
    document.addEventListener("visibilitychange", () => document.hidden || this.wake());
    document.addEventListener("resume", () => this.wake()); // after the browser froze the page
  }

  /** Whether the server is not reached: no socket, or no answers on it. */
  get lost(): boolean {
    return !this.up || (this.doubted > 0 && performance.now() - this.doubted > DOUBT_MS);
  }

  /** For how long the server has not been reached, ms. */
  get lostMs(): number {
    if (!this.lost) return 0;
    return performance.now() - (this.up ? this.doubted : this.downAt);
  }

  /** Return whether a message has come at or after that time (performance.now). */
  heardSince(at: number): boolean {
    return this.heard >= at;
  }

  /** How long the last answer took, ms; null before the first. */
  get latency(): number | null {
    return this.roundTrip.latency;
  }

  /** The least latency, which slowly grows, ms. */
  get best(): number {
    return this.roundTrip.best;
  }

  /** Whether the answer to a ping is overdue. */
  get overdue(): boolean {
    return this.roundTrip.overdue;
  }

  /** How much later than over the empty line what is sent now arrives, as far as is known, ms. */
  get lateMs(): number {
    return this.outgoing.lateMs;
  }

  /** Send a ping, unless one was sent a short time ago. */
  check(): void {
    if (this.roundTrip.due) this.ping();
  }

  now(): number {
    return Date.now() + this.roundTrip.offset;
  }

  send(message: object): boolean {
    if ((message as { t?: string }).t === "plan") this.plan = message;
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.outgoing.send(message, this.pack(message) ?? JSON.stringify(message));
    return true;
  }

  private open(): void {
    clearTimeout(this.retry);
    const before = this.socket;
    this.socket = null;
    before?.close();
    const socket = openSocket(`/ws/robots/${this.slug}/${this.query(false)}`);
    this.use(socket);
    socket.onopen = () => {
      this.begun();
      this.own.soon();
    };
  }

  private query(moved: boolean): string {
    return this.wish ? `?watch=${encodeURIComponent(JSON.stringify(this.wish(moved)))}` : "";
  }

  private begun(): void {
    this.opened += 1;
    this.roundTrip.forget();
    this.hear();
    this.set(true);
    this.ping();
    if (this.plan) this.send(this.plan); // its answer would have come over the socket before
  }

  private use(socket: WebSocket): void {
    this.socket = socket;
    this.known = this.full = false;
    this.pieces.clear();
    this.texts.clear();
    this.heads.clear();
    this.outgoing.clear();
    socket.onmessage = (event) => this.receive(event.data as string | ArrayBuffer);
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      if (event.code === STREAM_OVER) {
        this.open(); // the public view, without a pause
        return;
      }
      this.set(false);
      this.none = event.code === 4404;
      if (this.none) return;
      if (event.code === 4401 || event.code === 4403 || event.code === FULL)
        this.handlers.message({ t: "notice", text: event.reason, level: "warning" });
      this.full = event.code === FULL;
      const pause = (this.full ? FULL_MS : Math.min(8000, 400 * 2 ** this.tries++)) * (0.5 + Math.random());
      this.retry = window.setTimeout(() => this.open(), pause);
    };
  }

  /** Open the operator's stream beside this socket, and take it over; called again and again while the person drives. */
  operate(): void {
    if (this.socket !== null && this.socket === this.adopted) return;
    const open = this.socket?.readyState === WebSocket.OPEN;
    if (open ? !this.known : this.tries < HOPELESS) return; // the turn may be over
    let asked = "";
    void this.own.open(
      () => (asked = this.query(true)),
      (socket, first) => {
        if (this.handlers.busy?.()) return false;
        const before = this.socket;
        clearTimeout(this.retry);
        this.use((this.adopted = socket));
        this.begun();
        this.receive(first.data as string | ArrayBuffer);
        if (this.wish && asked !== this.query(true)) this.send(this.wish(true)); // it was changed meanwhile
        if (before) this.drain(before);
        return true;
      },
    );
  }

  /** Read the answers that still come over that socket, then close it. */
  private drain(socket: WebSocket): void {
    if (socket.readyState !== WebSocket.OPEN) {
      socket.onopen = () => socket.close();
      return;
    }
    socket.onmessage = (event) => {
      const { data } = event as MessageEvent<string | ArrayBuffer>;
      if (typeof data === "string" && data.startsWith(ANSWER)) this.receive(data);
    };
    socket.send(NOTHING);
    setTimeout(() => socket.close(), DRAIN_MS);
  }

  private hear(): void {
    this.heard = performance.now();
    this.doubted = 0;
  }

  private receive(data: string | ArrayBuffer): void {
    this.hear();
    this.handlers.took?.(typeof data === "string" ? data.length : data.byteLength);
    if (typeof data !== "string") {
      this.probeAfter = PROBE_MS;
      const whole = firstByte(data) === PIECE ? this.pieces.take(data) : data;
      if (whole === null) return;
      const packet = this.heads.note(isShort(firstByte(whole)) ? this.heads.take(whole) : decode(whole, this.layout, this.now()));
      if (packet === null) return;
      if ("jpeg" in packet) this.handlers.picture(packet);
      else if ("coded" in packet) this.handlers.video?.(packet);
      else if ("opus" in packet) this.handlers.sound?.(packet);
      else if ("knots" in packet) this.handlers.path?.(packet);
      else if ("data" in packet) this.handlers.stream?.(packet);
      else this.handlers.state(packet);
      return;
    }
    this.tries = 0;
    const text = data.startsWith(TEXT_PIECE) ? this.texts.take(data) : data;
    if (text === null) return;
    const message = JSON.parse(text) as Message;
    this.known ||= message.t === "snapshot";
    if (message.t === "plan") this.plan = null;
    if (message.t === "pong") {
      this.roundTrip.pong(message.n, message.now_ms);
      this.outgoing.answered(message.n);
    } else if (message.t === "snapshot") this.roundTrip.serverTime(message.now_ms);
    this.handlers.message(message);
  }

  /** Send a ping. Returns its number; 0 without an open socket. */
  private ping(): number {
    const n = this.roundTrip.ping();
    if (this.send({ t: "ping", n })) return n;
    this.roundTrip.unsent(n);
    return 0;
  }

  private beat(): void {
    setTimeout(() => {
      this.ping();
      this.beat();
    }, this.pingEvery());
  }

  /** Send a ping; without an answer the connection counts as lost, whatever the browser reports. */
  private probe(): void {
    if (!this.up || this.doubted) return;
    this.doubted = performance.now();
    this.deadAfter = DEAD_MS + SPREAD_MS * Math.random();
    this.probeAfter = Math.min(this.probeAfter * 2, this.pingEvery()); // a robot that is off sends nothing for long
    this.ping();
  }

  /** Check the socket of a page that is seen or runs again: it may be dead without an event, or wait for its next attempt. */
  private wake(): void {
    const state = this.socket?.readyState;
    if (this.none || this.full || state === WebSocket.CONNECTING) return;
    if (state !== WebSocket.OPEN) {
      this.set(false);
      this.tries = 0;
      this.open();
    } else if (performance.now() - this.heard > PROBE_MS) {
      this.probe();
      this.deadAfter = WOKEN_MS;
    }
  }

  private watch(): void {
    if (!this.up) return;
    if (performance.now() - this.heard > this.probeAfter) this.probe();
    if (this.doubted && performance.now() - this.doubted > this.deadAfter) {
      this.set(false);
      this.open();
    }
  }

  private set(up: boolean): void {
    if (up === this.up) return;
    if (!up) this.downAt = this.doubted || performance.now();
    this.up = up;
    this.doubted = 0;
    this.handlers.line(up);
  }
}
