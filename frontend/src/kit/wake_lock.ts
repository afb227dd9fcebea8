/** Keeps the screen on, where the browser can. */

export class ScreenWakeLock {
  private wanted = false;
  private lock: WakeLockSentinel | null = null;
  private asking = false;

  constructor() {
    // the browser ends the lock of a page that nobody sees
    document.addEventListener("visibilitychange", () => void this.ask());
  }

  /** Keep the screen on from now on, or no longer. */
  keep(on: boolean): void {
    if (on === this.wanted) return;
    this.wanted = on;
    if (on) void this.ask();
    else this.end();
  }

  private async ask(): Promise<void> {
    if (!this.wanted || document.hidden || this.asking || (this.lock && !this.lock.released) || !("wakeLock" in navigator)) return;
    this.asking = true;
    try {
      this.lock = await navigator.wakeLock.request("screen");
    } catch {
      // the battery is low, or the browser does not allow it
    }
    this.asking = false;
    this.settle();
  }

  /** Release a lock that came after the end of `keep`. */
  private settle(): void {
    if (!this.wanted) this.end();
  }

  private end(): void {
    this.lock?.release().catch(() => undefined);
    this.lock = null;
  }
}
