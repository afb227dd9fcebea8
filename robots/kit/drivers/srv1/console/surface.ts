/** Figure 6: the speed over both readings as a heat map, in the layout of the table of rules, with the present readings. */
import { set, shape } from "/static/farhand/v1/console.js";
import { type RuleSet, speed, type Variable } from "./fuzzy.ts";
import { gettext, translate } from "/static/farhand/v1/text.js";

const CELLS = 32,
  SIDE = 240,
  LEFT = 70,
  TOP = 44,
  MOST_M_S = 0.5;
/** The colours of viridis, which colour-blind people can read. */
const RAMP = ["68 1 84", "59 82 139", "33 145 140", "94 201 98", "253 231 37"].map((colour) => colour.split(" ").map(Number));

export class Surface {
  private cells: SVGRectElement[][] = [];
  private ticks: SVGGElement;
  private dot: SVGGElement;
  private rules: RuleSet | null = null;

  constructor(private svg: SVGSVGElement) {
    set(svg, { viewBox: `0 0 ${LEFT + SIDE + 30} ${TOP + SIDE + 44}` });
    const step = SIDE / CELLS;
    const cell = (i: number, j: number): SVGRectElement =>
      shape(svg, "rect", { x: LEFT + j * step, y: TOP + i * step, width: step, height: step, class: "cell" });
    for (let i = 0; i < CELLS; i++) this.cells.push(Array.from({ length: CELLS }, (_, j) => cell(i, j)));
    this.ticks = shape(svg, "g", { class: "ticks" });
    this.dot = shape(svg, "g", { class: "now", visibility: "hidden" });
    shape(this.dot, "circle", { r: 6, cx: 0, cy: 0 });
    this.legend();
  }

  /** Show the speeds of a rule set, whose peaks have to rise. */
  show(rules: RuleSet): void {
    this.rules = rules;
    const [first, second] = rules.inputs,
      all: number[] = [];
    for (const [i, row] of this.cells.entries())
      for (const [j, cell] of row.entries()) {
        const v = speed(rules, at(first, (i + 0.5) / CELLS), at(second, (j + 0.5) / CELLS));
        set(cell, { fill: Number.isNaN(v) ? "none" : colour(v) });
        if (!Number.isNaN(v)) all.push(v);
      }
    this.ticks.replaceChildren();
    for (const [n, label] of first.labels.entries())
      this.words(`${label} ${first.peaks[n]}`, LEFT - 8, TOP + SIDE * share(first, first.peaks[n]!), "end");
    for (const [n, label] of second.labels.entries())
      this.words(`${label} ${second.peaks[n]}`, LEFT + SIDE * share(second, second.peaks[n]!), TOP - 10, "middle");
    this.words(`${translate(first.name)} (${first.unit}) ↓`, 0, TOP - 30, "start");
    this.words(`${translate(second.name)} (${second.unit}) →`, LEFT + SIDE, TOP - 30, "end");
    const slow = Math.min(...all),
      fast = Math.max(...all);
    set(this.svg, {
      "aria-label": gettext("The speed over {first} and {second}: from {slow} to {fast} cm/s. The table has the same.", {
        first: translate(first.name),
        second: translate(second.name),
        slow: cm(slow),
        fast: cm(fast),
      }),
    });
  }

  /** Show the present readings; null if they are not known. */
  place(readings: readonly [number, number] | null): void {
    const rules = this.rules;
    set(this.dot, { visibility: readings && rules ? "visible" : "hidden" });
    if (!readings || !rules) return;
    const y = TOP + SIDE * share(rules.inputs[0], readings[0]),
      x = LEFT + SIDE * share(rules.inputs[1], readings[1]);
    set(this.dot, { transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})` });
  }

  private words(text: string, x: number, y: number, anchor: string): void {
    shape(this.ticks, "text", { x, y, "text-anchor": anchor, "dominant-baseline": "central" }).textContent = text;
  }

  private legend(): void {
    const y = TOP + SIDE + 12,
      step = SIDE / CELLS;
    for (let n = 0; n < CELLS; n++) {
      const fill = colour((MOST_M_S * n) / (CELLS - 1));
      shape(this.svg, "rect", { x: LEFT + n * step, y, width: step, height: 10, class: "cell", fill });
    }
    for (const [n, anchor] of ["start", "middle", "end"].entries()) {
      const words = `${50 * MOST_M_S * n}${n === 2 ? " cm/s" : ""}`;
      shape(this.svg, "text", { x: LEFT + (SIDE * n) / 2, y: y + 22, "text-anchor": anchor }).textContent = words;
    }
  }
}

/** A speed (m/s) in cm/s, for people. */
export function cm(speed: number): string {
  return (100 * speed).toFixed(1).replace(/\.0$/, "");
}

function at({ peaks }: Variable, part: number): number {
  return peaks[0]! + part * (peaks.at(-1)! - peaks[0]!);
}

function share({ peaks }: Variable, reading: number): number {
  return Math.min(Math.max((reading - peaks[0]!) / (peaks.at(-1)! - peaks[0]!), 0), 1);
}

function colour(speed: number): string {
  const x = Math.min(Math.max(speed / MOST_M_S, 0), 1) * (RAMP.length - 1),
    n = Math.min(Math.floor(x), RAMP.length - 2);
  return `rgb(${RAMP[n]!.map((v, k) => Math.round(v + (x - n) * (RAMP[n + 1]![k]! - v))).join(" ")})`;
}
