/** What this page wants to see: which cameras, and how much of it, as the person chose or as the line allows. */
import { kept } from "./kept.ts";
import { LineJudge, type Pace, PACES, quick } from "./pace.ts";

export const STILLS_S = 5; // between two pictures at the pace "stills"
const RATE_MS = 5000;

/** The part of a socket that is used here. */
interface Line {
  send(message: object): boolean; now(): number; check(): void;
  readonly latency: number | null; readonly best: number; readonly overdue: boolean; readonly lost: boolean;
}
interface Picture { camera: number; atMs: number }

const SAID: Record<Pace, string> = {
  live: "", stills: `Slow connection: a new picture every ${STILLS_S} seconds.`,
  states: "Very slow connection: only measured values, no new pictures.",
};

export class Watching {
  private cameras: number[] = [0];
  private chosen: Pace | null; // null: as the line allows
  private judge: LineJudge;
  private arrivals: number[] = []; // of the first wanted camera's pictures, performance.now
  private told = "";
  private expected = false;
  private fruitless = false; // nothing has arrived through this socket

  /** `whole`: everything is wanted, whatever was chosen for live pictures. */
  constructor(private line: () => Line, private saveData: boolean, whole = false) {
    this.chosen = whole ? "live" : PACES.find((pace) => pace === kept.get("pace")) ?? null;
    this.judge = this.begin();
  }

  private begin(): LineJudge {
    return new LineJudge(performance.now(), this.saveData ? "stills" : "live");
  }

  get pace(): Pace {
    return this.chosen ?? this.judge.pace;
  }

  /** What the person chose: a pace, or "auto". */
  get choice(): Pace | "auto" {
    return this.chosen ?? "auto";
  }

  choose(choice: string): void {
    this.chosen = PACES.find((pace) => pace === choice) ?? null;
    kept.set("pace", this.choice);
    this.judge = this.begin();
    this.arrivals = [];
    this.tell();
  }

  /** Have the pictures of these cameras. */
  want(cameras: number[]): void {
    this.cameras = cameras;
    this.arrivals = [];
    this.tell();
  }

  /** What a new socket asks for; one that follows another through which no picture came asks for less. */
  wish(): object {
    if (this.fruitless && this.expected) this.judge.down(performance.now());
    this.fruitless = true;
    const wish = this.wished();
    this.told = JSON.stringify(wish);
    return wish;
  }

  arrived(picture: Picture): void {
    if (picture.camera !== this.cameras[0]) return;
    const now = performance.now();
    this.fruitless = false;
    this.arrivals = [...this.arrivals.filter((at) => now - at < RATE_MS), now];
    this.judge.arrived(this.line().now() - picture.atMs);
  }

  /** Pictures a second, over the last seconds; 0 for fewer than one in two seconds. */
  rate(): number {
    const now = performance.now();
    const recent = this.arrivals.filter((at) => now - at < RATE_MS);
    const first = recent[0];
    return first === undefined || recent.length < 3 ? 0 : (recent.length - 1) / ((recent[recent.length - 1]! - first) / 1000);
  }

  /** Judge the line; `expected`: the robot sends pictures now. Returns what to say of it. */
  said(expected: boolean): string {
    const line = this.line();
    this.expected = expected;
    if (!line.lost) {
      if (expected && this.judge.doubts) line.check();
      const fast = quick(line.overdue ? null : line.latency, line.best);
      if (this.judge.judge(performance.now(), expected, fast)) this.tell();
    }
    return this.chosen === null ? SAID[this.judge.pace] : "";
  }

  private wished(): object {
    const { pace } = this;
    return {
      t: "watch", cameras: pace === "states" ? [] : this.cameras, every_s: pace === "stills" ? STILLS_S : 0,
      compact: pace !== "live",
    };
  }

  private tell(): void {
    const wish = this.wished(), written = JSON.stringify(wish);
    if (written !== this.told && this.line().send(wish)) this.told = written;
  }
}
