/** What the rover did without a connection, by its journal: read from the stream `unseen`, and in words. */
import { decimals, gettext, ngettext } from "/static/farhand/v1/text.js";

export type Point = readonly [number, number];
export interface Unseen {
  ways: Point[][];
  events: { ago: number; event: string }[];
}

const MOST = 2000; // points and events
const ENDED: Record<string, string> = {
  expired: gettext("and came to rest at the end of its permit"),
  left: gettext("and came to rest at the edge of the area that it may drive in by itself"),
  fast: gettext("and came to rest because it was too fast"),
  encoder: gettext("and came to rest because an encoder counts nothing"),
  heard: gettext("and was reached again, and went on"),
};

/** Read a packet; null if it cannot be read. */
export function readUnseen(data: Uint8Array): Unseen | null {
  let told: unknown;
  try {
    told = JSON.parse(new TextDecoder().decode(data));
  } catch {
    return null;
  }
  if (typeof told !== "object" || told === null) return null;
  const { ways, events } = told as { ways?: unknown; events?: unknown };
  if (!Array.isArray(ways) || !Array.isArray(events) || events.length > MOST) return null;
  const good = (at: unknown): at is Point => Array.isArray(at) && at.length >= 2 && at.slice(0, 2).every((v) => Number.isFinite(v));
  return {
    ways: ways.slice(0, MOST).map((way) => (Array.isArray(way) ? way.filter(good).slice(0, MOST) : [])),
    events: events.flatMap((one: unknown) =>
      Array.isArray(one) && Number.isFinite(one[0]) && typeof one[1] === "string" ? [{ ago: one[0] as number, event: one[1] }] : [],
    ),
  };
}

/** Return a sentence for each time out of reach. `atMs`: when the packet was made. */
export function unseenWords({ ways, events }: Unseen, atMs: number, clock: (ms: number) => string): string[] {
  const said: string[] = [];
  let begun: number | null = null,
    reflexes = 0,
    end = "";
  const close = (until: number): void => {
    if (begun === null) return;
    const way = ways[said.length] ?? [],
      metres = way.slice(1).reduce((sum, [x, y], i) => sum + Math.hypot(x - way[i]![0], y - way[i]![1]), 0);
    const halts = ngettext("turned away from something near once", "turned away from something near {count} times", reflexes);
    const driven = gettext("it drove {metres} m by itself", { metres: decimals(metres, 1) });
    const what = [driven, ...(reflexes ? [halts] : []), ...(end ? [end] : [])].join(", ");
    said.push(gettext("Out of reach from {from} to {until}: {what}.", { from: clock(begun), until: clock(until), what }));
    begun = null;
  };
  for (const { ago, event } of events) {
    const at = atMs - ago;
    if (event === "alone") {
      close(at);
      [begun, reflexes, end] = [at, 0, ""];
    } else if (event === "reflex") reflexes += 1;
    end = ENDED[event] ?? end;
    if (event in ENDED) close(at);
  }
  close(atMs);
  return said;
}
