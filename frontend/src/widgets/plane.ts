/** Points of a plane (m, y up) on a screen (px, y down), and places of the plane in words. */
import { gettext } from "../kit/text.ts";

interface Point {
  x: number;
  y: number;
}
export interface Box {
  left: number;
  right: number;
  low: number;
  high: number;
}

const LEAST_M = 0.8; // a map of a few points does not fill the screen
const MARGIN_PX = 26;
const LOOSE = 0.72; // a map that fills a smaller share of its frame gets a new frame

/** Return the frame of these points: the old one as long as they fill it, so that the map does not tremble. */
export function fittingBox(old: Box | null, points: readonly Point[]): Box | null {
  if (!points.length) return old;
  const box = { left: Infinity, right: -Infinity, low: Infinity, high: -Infinity };
  for (const { x, y } of points) {
    box.left = Math.min(box.left, x);
    box.right = Math.max(box.right, x);
    box.low = Math.min(box.low, y);
    box.high = Math.max(box.high, y);
  }
  const inside = old && box.left >= old.left && box.right <= old.right && box.low >= old.low && box.high <= old.high;
  if (inside && filled(box, old)) return old;
  const wide = Math.max(0, LEAST_M - (box.right - box.left)) / 2 + 0.05,
    tall = Math.max(0, LEAST_M - (box.high - box.low)) / 2 + 0.05;
  return { left: box.left - wide, right: box.right + wide, low: box.low - tall, high: box.high + tall };
}

function filled(box: Box, frame: Box): boolean {
  const width = Math.max(LEAST_M, box.right - box.left),
    height = Math.max(LEAST_M, box.high - box.low);
  return width > LOOSE * (frame.right - frame.left - 0.1) || height > LOOSE * (frame.high - frame.low - 0.1);
}

export class Scale {
  /** px per metre */
  readonly pixels: number;
  private x: number;
  private y: number;
  private width: number;
  private height: number;

  constructor(box: Box | null, width: number, height: number) {
    this.width = width;
    this.height = height;
    const { left, right, low, high } = box ?? { left: -LEAST_M, right: LEAST_M, low: -LEAST_M, high: LEAST_M };
    this.pixels = Math.max(1, Math.min((width - 2 * MARGIN_PX) / (right - left), (height - 2 * MARGIN_PX) / (high - low)));
    this.x = (left + right) / 2;
    this.y = (low + high) / 2;
  }

  toScreen(x: number, y: number): [number, number] {
    return [this.width / 2 + (x - this.x) * this.pixels, this.height / 2 - (y - this.y) * this.pixels];
  }

  toPlane(u: number, v: number): [number, number] {
    return [this.x + (u - this.width / 2) / this.pixels, this.y - (v - this.height / 2) / this.pixels];
  }
}

/** Return the number of the nearest place within `most` (m); null if there is none. */
export function nearest(places: ReadonlyMap<number, Point>, x: number, y: number, most: number): number | null {
  let found: number | null = null,
    least = most;
  for (const [id, place] of places) {
    const away = Math.hypot(place.x - x, place.y - y);
    if (away <= least) [found, least] = [id, away];
  }
  return found;
}

const LETTERS = Array.from("ABCDEFGHIJKLMNOPQRSTUVWXYZ");
const APART_M = 0.42;
const CLOSE_M = 0.2;

/** Return well-spread places with a letter each, for people who do not click; a letter stays as long as its place is known. */
export function landmarks(old: ReadonlyMap<string, number>, places: ReadonlyMap<number, Point>): Map<string, number> {
  const kept: [string, number][] = [];
  const far = (at: Point, least: number): boolean =>
    kept.every(([, id]) => Math.hypot(places.get(id)!.x - at.x, places.get(id)!.y - at.y) >= least);
  for (const [letter, id] of old) {
    const at = places.get(id);
    if (at && far(at, CLOSE_M)) kept.push([letter, id]);
  }
  for (const [id, at] of places) {
    if (kept.length === LETTERS.length) break;
    if (!far(at, APART_M)) continue;
    const used = new Set(kept.map(([letter]) => letter));
    kept.push([LETTERS.find((letter) => !used.has(letter))!, id]);
  }
  return new Map(kept.sort(([a], [b]) => (a < b ? -1 : 1)));
}

/** Return where a place is on the map as it is drawn: "top left", "centre", "bottom". */
export function whereabouts(at: Point, places: ReadonlyMap<number, Point>): string {
  const box = fittingBox(null, [...places.values(), at])!;
  const third = (share: number): 0 | 1 | 2 => (share < 1 / 3 ? 0 : share < 2 / 3 ? 1 : 2);
  const words = [
    [gettext("bottom left"), gettext("bottom"), gettext("bottom right")],
    [gettext("middle left"), gettext("centre"), gettext("middle right")],
    [gettext("top left"), gettext("top"), gettext("top right")],
  ] as const;
  return words[third((at.y - box.low) / (box.high - box.low))][third((at.x - box.left) / (box.right - box.left))];
}
