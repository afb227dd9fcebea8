/** How long answers take, and by how much the server's clock differs from this one: measured by pings. */

const OVERDUE_MS = 2000,
  CHECK_MS = 2000;
const MOST = 20; // pings without an answer that are remembered

export class RoundTrip {
  /** Server time minus ours, ms. */
  offset = 0;
  latency: number | null = null;
  /** The least latency, which slowly grows, ms. */
  best = Infinity;
  private pings = new Map<number, number>(); // when each was sent that has no answer
  private count = 0;
  private sentAt = 0;

  /** A ping is sent. Returns its number. */
  ping(): number {
    const n = ++this.count;
    this.sentAt = performance.now();
    this.pings.set(n, this.sentAt);
    if (this.pings.size > MOST) this.pings.clear();
    return n;
  }

  /** That one was not sent after all. */
  unsent(n: number): void {
    this.pings.delete(n);
  }

  /** Another socket: nothing is awaited over it. */
  forget(): void {
    this.pings.clear();
  }

  /** Its answer has come, with the server's time. */
  pong(n: number, serverMs: number): void {
    const sent = this.pings.get(n);
    this.pings.delete(n);
    if (sent === undefined) return;
    this.latency = performance.now() - sent;
    this.best = Math.min(this.best * 1.02, this.latency);
    // an answer that waited on the way tells nothing of the clock
    if (this.latency < 1.5 * this.best + 20) this.offset = serverMs + this.latency / 2 - Date.now();
  }

  /** The server's time came with something else, which counts until the first answer. */
  serverTime(serverMs: number): void {
    if (this.latency === null) this.offset = serverMs - Date.now();
  }

  /** Whether the answer to a ping is missing for long. */
  get overdue(): boolean {
    const [oldest] = this.pings.values();
    return oldest !== undefined && performance.now() - oldest > OVERDUE_MS;
  }

  /** Whether no ping was sent lately. */
  get due(): boolean {
    return performance.now() - this.sentAt > CHECK_MS;
  }
}
