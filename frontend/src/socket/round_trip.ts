/** The round-trip time of pings, and the difference between the server's clock and this one. */

const OVERDUE_MS = 2000,
  CHECK_MS = 2000;
const MOST = 20; // the most pings without an answer that are remembered

export class RoundTrip {
  /** Server time minus ours, ms. */
  offset = 0;
  latency: number | null = null;
  /** The least latency, which slowly grows, ms. */
  best = Infinity;
  private pings = new Map<number, number>(); // when each ping without an answer was sent
  private count = 0;
  private sentAt = 0;

  /** Note that a ping is sent. Returns its number. */
  ping(): number {
    const n = ++this.count;
    this.sentAt = performance.now();
    this.pings.set(n, this.sentAt);
    if (this.pings.size > MOST) this.pings.clear();
    return n;
  }

  /** Forget that ping, which could not be sent. */
  unsent(n: number): void {
    this.pings.delete(n);
  }

  /** Forget all pings: there is another socket. */
  forget(): void {
    this.pings.clear();
  }

  /** Take the answer to that ping, with the server's time (ms). */
  pong(n: number, serverMs: number): void {
    const sent = this.pings.get(n);
    this.pings.delete(n);
    if (sent === undefined) return;
    this.latency = performance.now() - sent;
    this.best = Math.min(this.best * 1.02, this.latency);
    // an answer that waited on the way says nothing about the clock
    if (this.latency < 1.5 * this.best + 20) this.offset = serverMs + this.latency / 2 - Date.now();
  }

  /** Take the server's time (ms) from another message; it counts until the first answer. */
  serverTime(serverMs: number): void {
    if (this.latency === null) this.offset = serverMs - Date.now();
  }

  /** Whether the answer to a ping is overdue. */
  get overdue(): boolean {
    const [oldest] = this.pings.values();
    return oldest !== undefined && performance.now() - oldest > OVERDUE_MS;
  }

  /** Whether the last ping was sent some time ago. */
  get due(): boolean {
    return performance.now() - this.sentAt > CHECK_MS;
  }
}
