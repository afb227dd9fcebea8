/** Parts of a page that are made in the background: asked for again until they have arrived, without a reload. */
import { morph } from "../kit/morph.ts";
import { request } from "../kit/request.ts";

const FIRST_MS = 1000,
  LONGEST_MS = 10_000,
  SLOWER = 1.4;

/** How long to wait before the part is asked for once more (ms). `moved`: there was news the last time. */
export function nextPause(pauseMs: number, moved: boolean): number {
  return moved ? FIRST_MS : Math.min(LONGEST_MS, pauseMs * SLOWER);
}

/** Ask for the page again while a part of it has still to arrive. */
export function pollPendingParts(): void {
  let pauseMs = FIRST_MS,
    timer = 0,
    asking = false;
  const parts = (): HTMLElement[] => [...document.querySelectorAll<HTMLElement>("[data-arrives]")];
  const later = (moved: boolean): void => {
    pauseMs = nextPause(pauseMs, moved);
    clearTimeout(timer);
    if (parts().length) timer = window.setTimeout(() => void ask(), pauseMs);
  };
  const ask = async (): Promise<void> => {
    if (asking || document.hidden || !parts().length) return;
    asking = true;
    let moved = false;
    try {
      const answer = await request(location.href, { headers: { Accept: "text/html" } });
      if (answer.ok) {
        const fresh = new DOMParser().parseFromString(await answer.text(), "text/html");
        for (const part of parts()) {
          const next = fresh.getElementById(part.id);
          if (next) moved = morph(part, document.importNode(next, true)) || moved;
        }
      }
    } catch {
      // no connection: it is asked for again
    }
    asking = false;
    later(moved);
  };
  document.addEventListener("visibilitychange", () => void ask());
  later(true);
}
