/** The way that the rover drove without a connection: dashed on the map, in the legend, and in words below it. */
import { byId, make, say, set, shape, type StreamPacket } from "/static/farhand/v1/console.js";
import { readUnseen, unseenWords } from "./unseen.ts";
import { gettext, language } from "/static/farhand/v1/text.js";

function timeOf(ms: number): string {
  const options = { hour: "2-digit", minute: "2-digit", second: "2-digit", hourCycle: "h23" } as const;
  return new Intl.DateTimeFormat(language(), options).format(new Date(ms));
}

export class UnseenPart {
  private ways: SVGPathElement;
  private words = make("p", { class: "hint", role: "status", hidden: "" });

  constructor(map: SVGSVGElement, before: SVGElement | null) {
    this.ways = shape(map, "path", { class: "unseen", d: "" });
    if (before) map.insertBefore(this.ways, before);
    const legend = byId("hall").parentElement?.querySelector(".legend");
    legend?.append(make("li", { class: "is-unseen" }, gettext("driven unseen")));
    legend?.after(this.words);
  }

  take({ data, atMs }: StreamPacket): void {
    const told = readUnseen(data);
    if (!told) return;
    set(this.ways, {
      d: told.ways.map((way) => way.map(([x, y], i) => `${i ? "L" : "M"} ${x.toFixed(3)} ${(-y).toFixed(3)}`).join(" ")).join(" "),
    });
    const words = unseenWords(told, atMs, (ms) => timeOf(ms));
    this.words.hidden = !words.length;
    say(this.words, words.join(" "));
  }
}
