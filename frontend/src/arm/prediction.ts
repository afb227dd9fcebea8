/** Where an arm is expected to be by the path of its motion, for as long as no state has confirmed or contradicted it. */
import { jointsAt } from "../socket/joint_path.ts";
import type { CommandInfo } from "../socket/messages.ts";
import type { JointMotion, PathPacket, StatePacket } from "../socket/packets.ts";
import { FINAL } from "../socket/stages.ts";

/** Joints (rad, m) that nothing has measured: an object, so that no code can take them for the joints of a state. */
export interface Predicted {
  readonly predicted: readonly number[];
}

/** Where a planned motion ends (rad, m), and how long it takes. */
export interface Planned {
  joints: readonly number[] | null;
  seconds: number;
}

const OFF_M = 0.01; // a state whose tool is farther off ends the prediction
const OFF_RAD = (2 * Math.PI) / 180; // or one of whose joints is
const LATE_MS = [0, -50, 50, -100, 100, -150, 150]; // by which the times of path and state may differ
const FRESH_MS = 300; // a confirmed state is shown alone for so long,
const PROMPT_MS = 100; // if it was no older when it came: over a slow line the arm is farther by then
const ANSWER_MS = 5000; // a motion that nobody has answered is expected for so long
const COMMANDS = 2 ** 32;
const MOST_OVER = 32; // commands that are remembered

export class Prediction {
  private path: PathPacket | null = null;
  private asked: (JointMotion & { seq: number; untilMs: number }) | null = null; // sent, and neither accepted nor refused
  private confirmedMs = -Infinity; // of the newest state on the path
  private over = new Set<number>(); // commands whose motion is expected no more
  private readonly now: () => number;
  private readonly tool: (joints: readonly number[]) => readonly number[] | null;

  /** `now`: server time (ms). `tool`: the tool's place (m) at such joints (rad, m); null while it is not known. */
  constructor(now: () => number, tool: (joints: readonly number[]) => readonly number[] | null) {
    [this.now, this.tool] = [now, tool];
  }

  /** Whether a motion is expected that no state has confirmed to its end. */
  get runs(): boolean {
    return this.path !== null || this.awaited !== null;
  }

  /** The motion that was asked for, while its path or its refusal may still come. */
  private get awaited(): JointMotion | null {
    return this.asked && this.now() < this.asked.untilMs ? this.asked : null;
  }

  /** Where the arm is expected to be now; null if nothing is, or if the newest state says so itself. */
  get joints(): Predicted | null {
    const now = this.now(),
      { awaited } = this;
    if (awaited) return { predicted: jointsAt(awaited, (now - awaited.beganMs) / 1000) };
    if (!this.path || now - this.confirmedMs < FRESH_MS) return null;
    return { predicted: jointsAt(this.path, (now - this.path.beganMs) / 1000) };
  }

  /**
   * Expect the motion of the page's command `seq`, which was just sent, until its path comes, its end, or 5 s have passed.
   * It begins from rest, when the command has arrived after `lateMs`, where the arm is expected, else at `measured` (rad, m).
   * `plan` returns where it ends, and after how long; it is not expected if that is not known (null, NaN).
   */
  ask(seq: number, measured: readonly number[], lateMs: number, plan: (from: readonly number[]) => Planned): void {
    const from = this.joints?.predicted ?? measured,
      { joints, seconds } = plan(from),
      now = this.now();
    if (!joints || !Number.isFinite(seconds)) return;
    const knots = [[...from], [...joints]];
    this.asked = { beganMs: now + lateMs, seconds, knots, velocity: [], seq, untilMs: now + ANSWER_MS };
  }

  /** Expect this motion from now on; not again if it was expected before. */
  begin(path: PathPacket): void {
    if (this.over.has(path.command) || path.command === this.path?.command) return;
    this.path = path;
    this.asked = null;
    this.confirmedMs = -Infinity;
  }

  /** Compare a state with what was expected at its time. */
  state(state: StatePacket): void {
    const { path } = this;
    if (state.stopped) this.asked = null;
    if (!path || state.atMs < path.beganMs) return;
    const endMs = path.beganMs + 1000 * path.seconds;
    const near = LATE_MS.some((late) => this.alike(state.joints, jointsAt(path, (state.atMs + late - path.beganMs) / 1000)));
    if (state.stopped || !near) return this.end(path.command);
    if (this.now() - state.atMs <= PROMPT_MS) this.confirmedMs = Math.max(this.confirmedMs, state.atMs);
    if (state.atMs >= endMs && !state.moving) this.end(path.command);
  }

  /** Take a stage of a command: one that did not complete its motion moves on its path no more. */
  command({ id, seq, state }: Pick<CommandInfo, "id" | "state"> & { seq?: number }): void {
    if (!FINAL.has(state)) return;
    if (seq === this.asked?.seq) this.asked = null;
    if (state !== "completed") this.end(id % COMMANDS);
  }

  private end(command: number): void {
    if (this.path?.command === command) this.path = null;
    this.over.add(command);
    if (this.over.size > MOST_OVER) this.over.delete([...this.over][0]!);
  }

  private alike(told: readonly number[], expected: readonly number[]): boolean {
    if (expected.some((q, i) => !(Math.abs(q - (told[i] ?? NaN)) <= OFF_RAD))) return false;
    const here = this.tool(told),
      there = here && this.tool([...expected, ...told.slice(expected.length)]);
    return !here || !there || Math.hypot(...here.map((v, i) => v - there[i]!)) <= OFF_M;
  }
}
