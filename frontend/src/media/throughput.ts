/** What a line carries: how many bytes come in a second, and how many would come if nothing were missed. */
import { isQuick } from "./pace.ts";
import { decimals, gettext } from "../kit/text.ts";

/** Bytes a second. */
export interface Carried {
  arrives: number;
  needs: number;
}
type Quality = "good" | "fair" | "poor";

const WINDOW_MS = 4000;
const FARTHEST = 200; // a greater gap between two numbers comes from another process or a pause
const ENOUGH = 0.6,
  ALL = 0.9; // of what is needed

/** Return whether so little arrives that the page has to ask for less. */
export function isShort({ arrives, needs }: Carried): boolean {
  return arrives < ENOUGH * needs;
}

/** Return the quality of the line, by the `latency` of the last ping (ms; null: overdue) and the `best` one so far. */
export function quality(carried: Carried, latency: number | null, best: number): Quality {
  if (isShort(carried) || latency === null) return "poor";
  return carried.arrives >= ALL * carried.needs && isQuick(latency, best) ? "good" : "fair";
}

/** Return the quality of the line and what comes, in words. */
export function lineWords(carried: Carried, latency: number | null, best: number): string {
  const word = quality(carried, latency, best),
    comes = kilobytes(carried.arrives);
  const rate =
    carried.arrives >= ALL * carried.needs
      ? `${comes} kB/s`
      : gettext("{part} of {whole} kB/s", { part: comes, whole: kilobytes(carried.needs) });
  if (word === "good") return gettext("Line good, {rate}", { rate });
  return word === "fair" ? gettext("Line fair, {rate}", { rate }) : gettext("Line poor, {rate}", { rate });
}

function kilobytes(bytes: number): string {
  const kB = bytes / 1000;
  return kB < 9.95 ? decimals(kB, 1) : String(Math.round(kB));
}

/** Counts what comes, over the last seconds; times are of one clock, in ms. */
export class ThroughputMeter {
  private taken: { at: number; bytes: number }[] = [];
  private pictures: { at: number; bytes: number; missed: number }[] = [];
  private last = new Map<number, number>(); // the number of each camera's newest picture
  private since: number;

  constructor(now: number) {
    this.since = now;
  }

  /** Note that so many bytes have come. */
  took(bytes: number, now: number): void {
    this.taken = [...this.taken.filter(({ at }) => now - at < WINDOW_MS), { at: now, bytes }];
  }

  /** Note that a picture was among them; each picture between it and the one before counts as missed. */
  picture(camera: number, number: number, bytes: number, now: number): void {
    const gap = number - (this.last.get(camera) ?? number) - 1;
    this.last.set(camera, number);
    const missed = gap > 0 && gap <= FARTHEST ? gap : 0;
    this.pictures = [...this.pictures.filter(({ at }) => now - at < WINDOW_MS), { at: now, bytes, missed }];
  }

  /** Begin again: the page has asked for something else, or did not run for a while. */
  begin(now: number): void {
    this.since = now;
    this.pictures = [];
    this.last.clear();
  }

  /** Return what came and what was needed; at most `most` pictures are sent in a second. */
  carried(now: number, most = Infinity): Carried {
    const window = Math.max(1, Math.min(WINDOW_MS, now - this.since)),
      seconds = window / 1000;
    const pictures = this.pictures.filter(({ at }) => now - at < window);
    const arrives = sum(this.taken.filter(({ at }) => now - at < WINDOW_MS).map(({ bytes }) => bytes)) / (WINDOW_MS / 1000);
    const wanted = Math.min(sum(pictures.map(({ missed }) => missed)), Math.max(0, most * seconds - pictures.length));
    const each = sum(pictures.map(({ bytes }) => bytes)) / Math.max(1, pictures.length);
    return { arrives, needs: arrives + (wanted * each) / seconds };
  }
}

function sum(values: number[]): number {
  return values.reduce((all, one) => all + one, 0);
}
