/**
 * The messages of a page over a thin line. Little is on the way at any time, measured by pings, because what the browser
 * and the system have taken cannot be overtaken any more; all others wait here. A stop goes before them, of the keep-alives
 * of a held motion only the newest waits, and long texts go in pieces (portal/live/pieces.py).
 */
import { TEXT_PIECE } from "./pieces.ts";

export type Data = string | Uint8Array<ArrayBuffer>;
/** The parts of a socket that `Outgoing` uses. */
interface Line {
  write(data: Data): void;
  /** Send a ping. Returns its number, 0 if it could not. */
  ping(): number;
  /** How long an answer takes over the empty line, as far as is known, ms. */
  best(): number;
  thin(): boolean;
}
interface Waiting {
  t: string;
  seq: number;
  data: Data;
  since: number;
  at: number; // characters of it that were written
}

const URGENT = ["stop", "ping", "watch"]; // the last may ask for less
const LEAST = 64,
  FIRST = 128,
  MOST = 1 << 16, // bytes that may be on the way
  SHORTEST = 40, // characters of a piece but the last; bytes between two pings
  HEAD = 6, // bytes of a frame's head
  LONG_MS = 300,
  SHORT_MS = 150; // by which a ping takes longer than the quickest one

export class Outgoing {
  private waiting: Waiting[] = [];
  private size = FIRST;
  private written = 0; // bytes since the socket was opened
  private arrived = 0; // of these, as far as is known
  private pinged = 0; // bytes until the end of the newest ping
  private pings: { n: number; position: number; at: number }[] = []; // without an answer
  private quickest = Infinity; // ms
  private readonly line: Line;

  constructor(line: Line) {
    this.line = line;
  }

  /** How much later than over the empty line what is sent now arrives, as far as is known, ms. */
  get lateMs(): number {
    const [first] = this.waiting;
    return Math.max(first ? performance.now() - first.since : 0, this.overdueMs);
  }

  private get overdueMs(): number {
    const [oldest] = this.pings;
    return oldest && this.quickest < Infinity ? performance.now() - oldest.at - this.quickest : 0;
  }

  /** Send a message, whose content is `data`. */
  send(message: { t?: string; seq?: number }, data: Data): void {
    const { t = "", seq = 0 } = message;
    if (!this.line.thin() && !this.waiting.length) {
      this.line.write(data); // it is not counted, because nothing measures when it arrives
      return;
    }
    if (URGENT.includes(t)) {
      this.write(data);
      return;
    }
    const known = this.waiting.find((one) => one.t === "keep" && one.seq === seq);
    if (known && (t === "keep" || t === "released")) Object.assign(known, { t, data });
    else this.waiting.push({ t, seq, data, since: performance.now(), at: 0 });
    this.pump();
  }

  /** Take the answer to a ping. */
  answered(n: number): void {
    const ping = this.pings.find((one) => one.n === n);
    if (!ping) return;
    const took = performance.now() - ping.at,
      full = this.written - this.arrived >= this.size / 2;
    this.quickest = Math.min(this.quickest, took, this.line.best());
    const waited = took - this.quickest;
    if (waited > LONG_MS) this.size = Math.max(LEAST, this.size * Math.max(0.5, LONG_MS / waited));
    else if (full && waited < SHORT_MS) this.size = Math.min(MOST, this.size + ping.position - this.arrived);
    this.arrived = ping.position;
    this.pings = this.pings.filter((one) => one.position > ping.position);
    this.pump();
  }

  /** Forget everything: there is another socket. */
  clear(): void {
    [this.waiting, this.pings, this.size, this.quickest] = [[], [], FIRST, Infinity];
    this.written = this.arrived = this.pinged = 0;
  }

  private pump(): void {
    while (this.waiting.length && this.written - this.arrived < this.size && this.overdueMs < LONG_MS) {
      this.write(this.next());
      this.measure();
    }
    if (this.waiting.length && !this.pings.length) this.measure(true); // else nothing would ever be written again
  }

  /** Let a ping follow what was written, several in a window. */
  private measure(always = false): void {
    if (!always && this.written - this.pinged < Math.max(SHORTEST, this.size / 3)) return;
    const at = performance.now(),
      n = this.line.ping();
    this.pinged = this.written;
    if (n) this.pings.push({ n, position: this.written, at });
  }

  private write(data: Data): void {
    this.written += HEAD + data.length;
    this.line.write(data);
  }

  /** Return what is written next: a message, or a piece of a long text. */
  private next(): Data {
    const one = this.waiting[0]!,
      { data, at } = one;
    if (typeof data !== "string" || (at === 0 && data.length <= this.size)) {
      this.waiting.shift();
      return data;
    }
    let end = Math.min(at + Math.max(SHORTEST, Math.floor(this.size / 3)), data.length);
    if (end < data.length && /[\ud800-\udbff]/.test(data[end - 1]!)) end -= 1; // both halves of a character go together
    one.at = end;
    if (end === data.length) this.waiting.shift();
    return `${TEXT_PIECE}${(at === 0 ? 1 : 0) + (end === data.length ? 2 : 0)}${data.slice(at, end)}`;
  }
}
