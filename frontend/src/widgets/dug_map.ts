/** What was dug and found in the present round, on a console's map, and in words for a place of it. */
import { shape } from "../kit/dom.ts";
import { prefetch } from "../kit/prefetch.ts";
import { request } from "../kit/request.ts";
import { gettext } from "../kit/text.ts";

/** The answer of `/robots/<robot>/dug.json`. */
interface Dug {
  area: readonly [left: number, low: number, right: number, high: number];
  cell_m: number;
  newest: number;
  cells: [column: number, row: number, count: number][];
  words: string[];
  more: string;
  found: [number: number, name: string, x: number, y: number][];
}
const LEVELS = 5;
const RADIUS_M = 0.014;

export class DugMap {
  private told: Dug | null = null;
  private counts = new Map<string, number>();
  private waiting = false;

  /** Draw into `group`, with `per` units a metre and y down. `address` is that of the answer; without one it is empty. */
  constructor(
    private page: { readonly idle: boolean; readonly thin: boolean },
    private group: SVGGElement,
    private address: string | undefined,
    private per: number,
  ) {}

  /** Ask for it while the page is idle, unless the line is thin. */
  load(): void {
    const { address } = this;
    if (!address || this.waiting) return;
    this.waiting = true;
    prefetch(this.page, async () => {
      this.waiting = false;
      if (this.page.thin) return;
      const answer = await request(address);
      if (answer.ok) this.take((await answer.json()) as Dug);
    });
  }

  /** The command of that number has dug at a place (m); one that was counted before changes nothing. */
  add(id: number, x: number, y: number): void {
    const square = this.square(x, y);
    if (!this.told || id <= this.told.newest || !square) return;
    this.told.newest = id;
    this.counts.set(square, (this.counts.get(square) ?? 0) + 1);
    this.draw();
  }

  /** Say what was dug at a place (m), as "about five bursts here"; empty where that is not known. */
  words(x: number, y: number): string {
    const square = this.square(x, y);
    if (!this.told || !square) return "";
    const count = this.counts.get(square) ?? 0;
    return count ? said(this.told, count) : gettext("nothing dug here yet");
  }

  private take(told: Dug): void {
    this.told = told;
    this.counts = new Map(told.cells.map(([column, row, count]) => [`${column},${row}`, count]));
    this.draw();
  }

  private square(x: number, y: number): string | null {
    if (!this.told) return null;
    const { area, cell_m } = this.told;
    const [left, low, right, high] = area;
    if (!(x >= left && x <= right && y >= low && y <= high)) return null;
    const along = (at: number, from: number, to: number): number =>
      Math.min(Math.floor((at - from) / cell_m), Math.ceil((to - from) / cell_m) - 1); // the edge belongs to the last square
    return `${along(x, left, right)},${along(y, low, high)}`;
  }

  private draw(): void {
    const { told, group, per } = this;
    if (!told) return;
    group.replaceChildren();
    const [left, low] = told.area;
    const side = told.cell_m * per;
    for (const [square, count] of this.counts) {
      const [column = 0, row = 0] = square.split(",").map(Number);
      const at = { x: left * per + column * side, y: -(low * per + (row + 1) * side), width: side, height: side };
      const level = Math.min(LEVELS, 1 + Math.floor(Math.log2(count)));
      shape(shape(group, "rect", { ...at, class: `dug dug-${level}` }), "title", {}).textContent = said(told, count);
    }
    for (const [number, name, x, y] of told.found) {
      const one = shape(group, "g", { class: "found" });
      shape(one, "title", {}).textContent = name;
      shape(one, "circle", { cx: x * per, cy: -y * per, r: RADIUS_M * per });
      shape(one, "text", { x: x * per, y: -y * per, "text-anchor": "middle", "dominant-baseline": "central" }).textContent = `${number}`;
    }
  }
}

function said({ words, more }: Dug, count: number): string {
  return words[count - 1] ?? more.replace("{number}", `${count}`);
}
