/** The rule sets that this device has sent, by the CRC with which the rover says which one is in force. */
import { crcOf, parse } from "./rules_text.ts";

const MOST = 20,
  KEY = "srv1-rules";

export class RuleMemory {
  private known = new Map<number, string>();

  /** `paper`: the rover's first set, whose number is 0. */
  constructor(private paper: string) {
    try {
      for (const [crc, text] of JSON.parse(localStorage.getItem(KEY) ?? "[]") as [number, string][]) {
        parse(text); // throws where it is no rule set
        this.known.set(crc, text);
      }
    } catch {
      // stored data that cannot be read
    }
    this.add(paper);
  }

  add(text: string): void {
    this.known.set(text === this.paper ? 0 : crcOf(text), text);
    try {
      localStorage.setItem(KEY, JSON.stringify([...this.known].slice(-MOST)));
    } catch {
      // then it is unknown after a reload
    }
  }

  /** Return the text of that set; undefined if somebody else has sent it. */
  get(crc: number): string | undefined {
    return this.known.get(crc);
  }
}
