/** What a line carries: how many bytes a second come, and how many would if all that was asked for came. */
import { isQuick } from "./pace.ts";

/** Bytes a second. */
export interface Carried {
  arrives: number;
  needs: number;
}
export type Quality = "good" | "fair" | "poor";

const WINDOW_MS = 4000;
const FARTHEST = 200; // a greater gap between two pictures' numbers is of another process, or of a pause
const ENOUGH = 0.6,
  ALL = 0.9; // of what is needed

/** Whether so little arrives that less has to be asked for. */
export function isShort({ arrives, needs }: Carried): boolean {
  return arrives < ENOUGH * needs;
}

/** The line in a word; `latency` of the last ping (null: its answer is overdue) and the `best` one so far are in ms. */
export function quality(carried: Carried, latency: number | null, best: number): Quality {
  if (isShort(carried) || latency === null) return "poor";
  return carried.arrives >= ALL * carried.needs && isQuick(latency, best) ? "good" : "fair";
}

/** The same for the person who watches, with what comes. */
export function lineWords(carried: Carried, latency: number | null, best: number): string {
  const word = quality(carried, latency, best),
    all = carried.arrives >= ALL * carried.needs;
  return `Line ${word}, ${all ? "" : `${kilobytes(carried.arrives)} of `}${kilobytes(all ? carried.arrives : carried.needs)} kB/s`;
}

function kilobytes(bytes: number): string {
  const kB = bytes / 1000;
  return kB < 9.95 ? kB.toFixed(1) : String(Math.round(kB));
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

  /** So many bytes have come. */
  took(bytes: number, now: number): void {
    this.taken = [...this.taken.filter(({ at }) => now - at < WINDOW_MS), { at: now, bytes }];
  }

  /** Some of them were this picture of a stream in which each is wanted; those between it and the one before are missed. */
  picture(camera: number, number: number, bytes: number, now: number): void {
    const gap = number - (this.last.get(camera) ?? number) - 1;
    this.last.set(camera, number);
    const missed = gap > 0 && gap <= FARTHEST ? gap : 0;
    this.pictures = [...this.pictures.filter(({ at }) => now - at < WINDOW_MS), { at: now, bytes, missed }];
  }

  /** Something else was asked for, or nobody has listened for a while. */
  begin(now: number): void {
    this.since = now;
    this.pictures = [];
    this.last.clear();
  }

  /** What came and what was needed; of pictures no more are sent than `most` a second. */
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
