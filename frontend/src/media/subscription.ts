/** What this page asks for: which cameras, and how much of them, as the person chose or as the line allows. */
import { storage } from "../kit/storage.ts";
import { gettext } from "../kit/text.ts";
import type { Connection } from "../socket/connection.ts";
import type { Coding } from "../socket/packets.ts";
import { LineJudge, type Pace, PACES, isQuick } from "./pace.ts";
import { lineWords, ThroughputMeter, quality, isShort } from "./throughput.ts";

const STILLS_S = 5; // between two pictures at the pace "stills"
const RATE_MS = 5000;
const NO_VIDEO_MS = 4000; // after so long without a picture of the video the robot's encoder may have failed,
const REST_MS = 5000,
  REST_MOST_MS = 60_000; //   and the page asks for JPEG for about so long, twice as long each time, up to the maximum
const FLOWS_MS = 10_000; // video that has come for so long works
const COARSE_HZ = 5; // the most coarse pictures that are sent in a second
const TICK_MS = 1000; // after so long without a judgement the page did not run

type Line = Pick<Connection, "send" | "now" | "check" | "latency" | "best" | "overdue" | "lost">;
interface Picture {
  camera: number;
  atMs: number;
  number: number;
}

const SAID: Record<Pace, string> = {
  live: "",
  coarse: gettext("Slow connection: the pictures are coarse."),
  stills: gettext("Slow connection: a new picture every {seconds} seconds.", { seconds: STILLS_S }),
  states: gettext("Very slow connection: only measured values, no new pictures."),
};

export class Subscription {
  private cameras: number[] = [0];
  private chosen: Pace | null; // null: as the line allows
  private judge: LineJudge;
  private meter = new ThroughputMeter(performance.now());
  private arrivals: number[] = []; // of the first wanted camera's pictures, performance.now
  private told = "";
  private expected = false;
  private film = false; // whether this page decodes video
  private sound = false; // whether the person listens
  private restsUntil = 0; // until then the page does without video, performance.now
  private filmedSince = 0; // when video was asked for, or its last picture came, performance.now; 0: not asked for
  private filmsSince = 0; // when the first picture of the video came, performance.now; 0: none
  private restMs = REST_MS; // how long about the next pause without video lasts
  private saidAt = 0;
  private fruitless = false; // whether no picture has come over this socket

  private readonly line: () => Line;
  private readonly coding: Coding;
  private readonly saveData: boolean;

  /** `whole`: ask for everything, whatever the person chose for live pictures. */
  constructor(line: () => Line, coding: Coding, saveData: boolean, whole = false) {
    [this.line, this.coding, this.saveData] = [line, coding, saveData];
    this.chosen = whole ? "live" : (PACES.find((pace) => pace === storage.get("pace")) ?? null);
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
    storage.set("pace", this.choice);
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

  /** Ask for pictures as video from now on, or no longer. */
  video(on: boolean): void {
    this.film = on;
    this.tell();
  }

  /** Ask for the robot's sound from now on, or no longer. */
  listen(on: boolean): void {
    this.sound = on;
    this.tell();
  }

  /** Why no sound is sent to this page; empty if it may be. */
  get soundless(): string {
    if (this.whole) return "";
    return this.chosen === null ? gettext("No sound over so slow a connection.") : gettext("No sound while so little is asked for.");
  }

  /** Ask again, so that the video begins with the newest key picture. */
  again(): void {
    if (!this.filmedSince) return;
    this.told = "";
    this.tell();
  }

  /**
   * Return what a new socket asks for: less, if no picture came over the socket before. `moved`: the socket before has
   * not failed.
   */
  wish(moved = false): object {
    if (!moved) {
      if (this.fruitless && this.expected) this.judge.down(performance.now());
      this.fruitless = false; // an attempt that never opens says nothing about how much a line carries
    }
    const wish = this.wished();
    this.asked(JSON.stringify(wish));
    return wish;
  }

  /** A socket has opened. */
  opened(): void {
    this.fruitless = true;
  }

  /** A message of so many bytes has come. */
  took(bytes: number): void {
    this.meter.took(bytes, performance.now());
  }

  /** A picture of so many bytes has come. */
  arrived(picture: Picture, bytes: number): void {
    const now = performance.now();
    if (this.whole) this.meter.picture(picture.camera, picture.number, bytes, now);
    if (picture.camera !== this.cameras[0]) return;
    this.fruitless = false;
    if (this.filmedSince) this.filmed(now);
    this.arrivals = [...this.arrivals.filter((at) => now - at < RATE_MS), now];
    this.judge.arrived(this.line().now() - picture.atMs);
  }

  private filmed(now: number): void {
    this.filmedSince = now;
    this.filmsSince ||= now;
    if (now - this.filmsSince > FLOWS_MS) this.restMs = REST_MS;
  }

  /** Do without video for a random time, so that not all pages come back at once and load the robot's host. */
  private rest(now: number): void {
    this.restsUntil = now + this.restMs * (0.5 + Math.random() / 2);
    this.restMs = Math.min(2 * this.restMs, REST_MOST_MS);
  }

  /** Return the pictures per second over the last seconds; 0 for less than one in two seconds. */
  rate(): number {
    const now = performance.now();
    const recent = this.arrivals.filter((at) => now - at < RATE_MS);
    const first = recent[0];
    return first === undefined || recent.length < 3 ? 0 : (recent.length - 1) / ((recent[recent.length - 1]! - first) / 1000);
  }

  /** Judge the line; `expected`: the robot sends pictures now. Returns the sentence about a slow one. */
  judgeLine(expected: boolean): string {
    const line = this.line();
    this.expected = expected;
    if (!line.lost) {
      const now = performance.now();
      if (expected && this.judge.doubts) line.check();
      const fast = isQuick(line.overdue ? null : line.latency, line.best);
      if (this.filmedSince && now - this.saidAt > TICK_MS) this.filmedSince = now;
      if (now - this.saidAt > TICK_MS) this.meter.begin(now); // the page did not run
      this.saidAt = now;
      if (expected && fast && this.filmedSince && now - this.filmedSince > NO_VIDEO_MS) this.rest(now);
      this.judge.judge(now, expected, fast, isShort(this.carried(now)));
      this.tell();
    }
    return this.chosen === null ? SAID[this.judge.pace] : "";
  }

  /** Return the line in a word, and what comes over it; empty without a connection. */
  lineSentence(): string {
    const line = this.line();
    if (line.lost || (line.latency === null && !line.overdue)) return "";
    return lineWords(this.carried(performance.now()), line.overdue ? null : line.latency, line.best);
  }

  /** Whether this page asks for everything and the line carries it. */
  get good(): boolean {
    const line = this.line();
    if (this.pace !== "live" || line.lost || line.overdue) return false;
    return quality(this.carried(performance.now()), line.latency, line.best) === "good";
  }

  private carried(now: number): { arrives: number; needs: number } {
    return this.meter.carried(now, this.pace === "coarse" ? COARSE_HZ * this.cameras.length : Infinity);
  }

  /** Whether each picture is wanted, whole or coarse. */
  private get whole(): boolean {
    return this.pace === "live" || this.pace === "coarse";
  }

  /** Whether long messages come in pieces, so that answers are never far behind. */
  get inPieces(): boolean {
    return this.pace === "stills" || this.pace === "states";
  }

  private get filming(): boolean {
    return this.film && performance.now() >= this.restsUntil && this.whole && this.cameras.length > 0;
  }

  private wished(): object {
    const { pace } = this;
    return {
      t: "watch",
      cameras: pace === "states" ? [] : this.cameras,
      every_s: pace === "stills" ? STILLS_S : 0,
      compact: pace !== "live",
      ...(this.filming ? { video: this.coding } : {}),
      ...(pace === "coarse" ? { coarse: true } : {}),
      ...(this.inPieces ? { pieces: true } : {}),
      ...(this.sound && !this.soundless ? { sound: true } : {}),
    };
  }

  /** Send what this page wants if the server does not know it; a socket that is not open yet sends nothing. */
  tell(): void {
    const wish = this.wished(),
      written = JSON.stringify(wish);
    if (written !== this.told && this.line().send(wish)) this.asked(written);
  }

  private asked(written: string): void {
    this.told = written;
    this.meter.begin(performance.now());
    this.filmedSince = this.filming ? performance.now() : 0;
    this.filmsSince = 0;
  }
}
