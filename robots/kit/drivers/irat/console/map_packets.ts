/** Reads the byte stream `map`: experiences, links, the way to the goal, places from where the dock was seen. */
import type { Graph, Spot } from "/static/farhand/v1/roaming.js";

const VERSION = 1;
const HEAD = 14;
const ROUTE = 1;
const DOCKS = 2;
const DOCK = 4;
const UNIT_M = 0.005;

/** The map by the packets so far. */
export class ExperienceMap implements Graph {
  number = 0;
  spots = new Map<number, Spot>();
  links: [number, number][] = [];
  route: number[] = [];
  docks: number[] = [];
  /** The dock, once its place is known; only docking leads to places within that distance of it (m). */
  dock: (Spot & { within: number }) | null = null;

  /** Return the places of the map to which people may send the robot. */
  open(): Map<number, Spot> {
    const { dock } = this;
    if (!dock) return this.spots;
    return new Map([...this.spots].filter(([, { x, y }]) => Math.hypot(x - dock.x, y - dock.y) >= dock.within));
  }

  /** Take a key packet or a delta. Returns false for one that cannot be read; after that only a key packet helps. */
  take(data: Uint8Array, key: boolean): boolean {
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    if (data.byteLength < HEAD || view.getUint8(0) !== VERSION) return false;
    const flags = view.getUint8(1),
      number = view.getUint32(2, true),
      n = view.getUint32(6, true),
      m = view.getUint32(10, true);
    if (!key && number !== this.number) return false;
    const links = HEAD + 8 * n,
      lists = links + 8 * m;
    if (lists > data.byteLength) return false;
    const route = flags & ROUTE ? idsAt(view, lists) : null;
    const docks = flags & DOCKS ? idsAt(view, lists + lengthOf(route)) : null;
    if ((flags & ROUTE && !route) || (flags & DOCKS && !docks)) return false;
    const place = lists + lengthOf(route) + lengthOf(docks);
    if (flags & DOCK && place + 6 > data.byteLength) return false;
    if (key) {
      this.spots = new Map();
      this.links = [];
    }
    this.number = number;
    for (let i = 0; i < n; i++) {
      const x = view.getInt16(HEAD + 4 * n + 2 * i, true) * UNIT_M,
        y = view.getInt16(HEAD + 6 * n + 2 * i, true) * UNIT_M;
      this.spots.set(view.getUint32(HEAD + 4 * i, true), { x, y });
    }
    for (let i = 0; i < m; i++) this.links.push([view.getUint32(links + 8 * i, true), view.getUint32(links + 8 * i + 4, true)]);
    if (route || key) this.route = route ?? [];
    if (docks || key) this.docks = docks ?? [];
    if (flags & DOCK || key) {
      const within = flags & DOCK ? view.getUint16(place + 4, true) * UNIT_M : 0;
      this.dock = within ? { x: view.getInt16(place, true) * UNIT_M, y: view.getInt16(place + 2, true) * UNIT_M, within } : null;
    }
    return true;
  }
}

/** Return the length of a list in bytes; 0 without a list. */
function lengthOf(list: number[] | null): number {
  return list ? 2 + 4 * list.length : 0;
}

/** Return the list of numbers that begins there; null if it is cut off. */
function idsAt(view: DataView, at: number): number[] | null {
  if (at + 2 > view.byteLength) return null;
  const count = view.getUint16(at, true);
  if (at + 2 + 4 * count > view.byteLength) return null;
  return Array.from({ length: count }, (_, i) => view.getUint32(at + 2 + 4 * i, true));
}
