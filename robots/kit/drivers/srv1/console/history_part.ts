/** Small lines beside the readings: what each was in the last five minutes. */
import { make, type RobotPage, set, shape } from "/static/farhand/v1/console.js";
import { added, inWords, line, type Sample } from "./history.ts";

/** A reading: its channel, its name in the table, how it is said, and the smallest range that fills a line's height. */
export interface Reading {
  channel: string;
  name: string;
  words: (value: number) => string;
  least: number;
}

export class HistoryPart {
  private samples = new Map<string, readonly Sample[]>();
  private lines = new Map<string, SVGPolylineElement>();

  constructor(
    private page: RobotPage,
    private readings: readonly Reading[],
    private body: HTMLElement,
  ) {}

  /** After the table was filled. */
  draw(at: number): void {
    for (const { channel, name, words, least } of this.readings) {
      const before = this.samples.get(channel) ?? [],
        samples = added(before, at, this.page.value(channel));
      this.samples.set(channel, samples);
      const row = [...this.body.querySelectorAll("tr")].find((one) => one.querySelector("th")?.textContent === name);
      if (!row || (samples === before && row.querySelector(".history"))) continue;
      const drawn = this.lineIn(row, channel);
      set(drawn, { points: line(samples, at, least) });
      const title = drawn.parentElement?.querySelector("title");
      if (title) title.textContent = inWords(name, samples, words);
    }
  }

  private lineIn(row: HTMLTableRowElement, channel: string): SVGPolylineElement {
    const known = this.lines.get(channel);
    if (known && row.contains(known)) return known;
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    set(svg, { viewBox: "0 0 100 20", class: "history", role: "img", preserveAspectRatio: "none" });
    shape(svg, "title", {});
    const drawn = shape(svg, "polyline", { points: "" });
    row.append(make("td", {}, svg));
    this.lines.set(channel, drawn);
    return drawn;
  }
}
