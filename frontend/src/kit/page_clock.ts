/** The one clock of a page for everything that is drawn or checked periodically, so that countdowns change together. */

const TICK_MS = 250;
interface Call {
  everyMs: number;
  lastMs: number;
  act(): void;
}
const calls = new Set<Call>();
let timer: ReturnType<typeof setInterval> | undefined;

/** Call `act` every `everyMs`, a multiple of 250 ms. Returns a function that ends it. */
export function every(everyMs: number, act: () => void): () => void {
  const call = { everyMs, lastMs: performance.now(), act };
  calls.add(call);
  timer ??= setInterval(tick, TICK_MS);
  return () => {
    calls.delete(call);
    if (calls.size) return;
    clearInterval(timer);
    timer = undefined;
  };
}

function tick(): void {
  const now = performance.now();
  for (const call of [...calls]) {
    if (now - call.lastMs < call.everyMs - TICK_MS / 2) continue;
    call.lastMs = now;
    try {
      call.act();
    } catch (error) {
      reportError(error); // the others go on
    }
  }
}
