/** Parts of a page that are made in the background: asked for again until they have arrived, without a reload. */
import { morph } from "../kit/morph.ts";
import { request } from "../kit/request.ts";

const FIRST_MS = 1000,
  LONGEST_MS = 10_000,
  SLOWER = 1.4;

/** Return the pause before the next request (ms). `changed`: the answer before brought something new. */
export function nextPause(pauseMs: number, changed: boolean): number {
  return changed ? FIRST_MS : Math.min(LONGEST_MS, pauseMs * SLOWER);
}

/** Ask for the page again while a part of it has still to arrive. */
export function pollPendingParts(): void {
  let pauseMs = FIRST_MS,
    timer = 0,
    asking = false;
  const parts = (): HTMLElement[] => [...document.querySelectorAll<HTMLElement>("[data-arrives]")];
  const later = (changed: boolean): void => {
    pauseMs = nextPause(pauseMs, changed);
    clearTimeout(timer);
    if (parts().length) timer = window.setTimeout(() => void ask(), pauseMs);
  };
  const ask = async (): Promise<void> => {
    if (asking || document.hidden || !parts().length) return;
    asking = true;
    const changes = new MutationObserver(() => undefined);
    try {
      const answer = await request(location.href, { headers: { Accept: "text/html" } });
      const fresh = answer.ok ? new DOMParser().parseFromString(await answer.text(), "text/html") : null;
      for (const part of fresh ? parts() : []) {
        changes.observe(part, { attributes: true, characterData: true, childList: true, subtree: true });
        const next = fresh?.getElementById(part.id);
        if (next) morph(part, document.importNode(next, true));
      }
    } catch {
      // no connection: it is asked for again
    }
    asking = false;
    later(changes.takeRecords().length > 0);
    changes.disconnect();
  };
  document.addEventListener("visibilitychange", () => void ask());
  later(true);
}
