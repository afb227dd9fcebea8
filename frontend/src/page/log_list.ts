/** The newest entries of the operator's log beside the picture. */
import { say } from "../kit/dom.ts";
import { arrange } from "../kit/parts.ts";
import type { LogInfo } from "../socket/protocol.ts";
import { ago } from "../kit/times.ts";

export class LogList {
  private items = new Map<number, HTMLElement>();

  constructor(private list: HTMLElement) {}

  draw(entries: readonly LogInfo[], now: number): void {
    for (const id of this.items.keys()) if (!entries.some((e) => e.id === id)) this.items.delete(id);
    arrange(this.list, entries.map((entry) => this.item(entry, now)));
  }

  private item(entry: LogInfo, now: number): HTMLElement {
    const item = this.items.get(entry.id) ?? made(entry);
    this.items.set(entry.id, item);
    for (const [name, words] of [["time", ` ${ago(now - entry.at_ms)} ago`], ["p", entry.text]] as const)
      say(item.querySelector(name)!, words);
    return item;
  }
}

function made(entry: LogInfo): HTMLElement {
  const item = document.createElement("li");
  const head = document.createElement("b");
  head.textContent = entry.author;
  item.append(head, document.createElement("time"), document.createElement("p"));
  if (entry.picture) {
    const image = new Image(96, 82);
    image.src = entry.picture;
    image.alt = `Picture chosen by ${entry.author}`;
    item.prepend(image);
  }
  return item;
}
