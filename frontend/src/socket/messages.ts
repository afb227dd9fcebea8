/** The messages of the socket in JSON; states, pictures and the like are binary packets. */
import type { CommandLayout } from "./command_packet.ts";
import type { Coding, CompactLayout } from "./packets.ts";

export interface Still {
  id: number;
  url: string;
  at_ms: number;
  stable: boolean;
  verdict: string;
  /** Where the robot was: coordinates that its spec declares, joints (rad, m), and values of its channels by name. */
  pose: number[];
  joints: number[];
  values: Record<string, number>;
  width: number;
  height: number;
  /** The result of the robot's own calibration at that time; its console knows what it holds. */
  calibration: Record<string, unknown>;
}
/** Where a command takes the robot. */
export interface Target {
  /** What it does, as a sentence; a portal of before does not say. */
  words?: string;
  /** Coordinates of the robot's pose by the names of its spec (m, rad), if the command names a place. */
  place?: Record<string, number>;
}
export interface CommandInfo {
  id: number;
  seq: number;
  grant: number;
  kind: string;
  state: string;
  reason: string;
  at_ms: number;
  by?: string;
  /** For a command of this page: the number of the socket over which it went, counted from 1. */
  over?: number;
  /** The progress of a long command; `share` is from 0 to 1, or null if the robot does not say. */
  progress?: { text?: string; share?: number | null; at_ms?: number };
  /** When the picture that its sender saw and the robot's newest one were taken (server ms); null: not known. */
  seen_ms?: number | null;
  newest_ms?: number | null;
  /** The values that were limited, by name. */
  clamping?: Record<string, [asked: number, sent: number]>;
  /** From when it is sent to the robot until it ends. */
  target?: Target;
  result?: { verdict?: string; note?: string; still?: number; stable?: boolean; picture?: string | null };
}
export interface LogInfo {
  id: number;
  author: string;
  text: string;
  at_ms: number;
  picture: string | null;
  featured: boolean;
}
/** How a turn or a place ended: why, what it cost, and what is next. */
export interface EndReason {
  why: string;
  credited: string;
  next: string;
}
export interface EndedTurn extends EndReason {
  turn: number;
  ended_ms: number;
  own: boolean;
  written: boolean;
}
export interface StopShown {
  confirmed: boolean;
  since_ms: number | null;
  rests_by_ms: number | null;
}
/** An open job of the robot, as everybody sees it. `ahead`: requests before it; `wait_s`: the least and greatest wait. */
export interface JobInfo {
  id: number;
  kind: string;
  state: string;
  args: Record<string, number>;
  ahead: number;
  wait_s: [number, number] | null;
}
export interface Snapshot {
  t: "snapshot";
  now_ms: number;
  link: boolean;
  store: string;
  /** Whether it belongs to a recording: nothing can be commanded. */
  replay?: boolean;
  robot: {
    slug: string;
    name: string;
    state: string;
    label: string;
    why: string;
    turns: boolean;
    simulated?: boolean;
    /** Whether something moves it: a person, a job, staff or itself. */
    moves?: boolean;
    /** Whether somebody who joins now drives at once. */
    free?: boolean;
    /** Whether they drive within seconds: it is free, or nobody waits and it leaves what it does by itself. */
    soon?: boolean;
    /** For which robot people practise on this simulator, and how long without an account (s; null: not at all). */
    practice?: { slug: string; name: string; guest_s: number | null } | null;
  };
  stopped: boolean;
  operator: string | null;
  queue: number;
  /** The least and greatest wait (s) behind everybody who waits now; null: not known, or the reader drives. */
  join_wait_s?: [number, number] | null;
  /** After a stop, jobs and the robot's own behaviour wait until staff resume them. */
  suspended: boolean;
  /** In the order in which they will be served. */
  jobs: JobInfo[];
  /** The latched stop: whether the robot confirmed that it rests, and if not, the latest time by which it rests. */
  stop: StopShown | null;
  turn: null | {
    id: number | null;
    grant: number;
    mine: boolean;
    until_ms: number | null;
    next_seq: number;
    extra: boolean;
    staff: boolean;
    wanted: boolean;
    /** Whether people who watch may cheer for who drives; a portal of before does not say. */
    cheers?: boolean;
  };
  me: {
    signed_in: boolean;
    /** Whether they practise without an account. */
    guest?: boolean;
    name?: string;
    cleared: boolean;
    /** Whether they have read the orientation; a portal of before does not say. */
    read?: boolean;
    staff?: boolean;
    last_turn?: number | null;
    /** The last turn here, if it ended lately or has no entry in the log: why it ended, what it cost, what is next. */
    last_end?: null | EndedTurn;
    /** What this person can do now; `ask` is for jobs. */
    can: { watch: boolean; drive: boolean; ask: boolean; stop: boolean };
    ticket: null | { state: string; ahead: number; wait_s: [number, number] | null; offer_until_ms: number | null };
  };
  still: Still | null;
  before: Still | null;
  commands: CommandInfo[];
  log: LogInfo[];
}
export interface ArgumentInfo {
  name: string;
  unit: string;
  low: number;
  high: number;
  required: boolean;
  text: boolean;
  whole: boolean;
  label: string;
  help: string;
}
export interface CommandSpec {
  kind: string;
  label: string;
  lane: "motion" | "config";
  arguments: ArgumentInfo[];
  /** By argument, the joint, coordinate or channel that shows its value at the end. */
  shown: Record<string, string>;
  held: boolean;
  steered: boolean;
  replaceable: boolean;
}
/** A value beside the joints, as a battery's charge: its unit and its usual range. */
export interface ChannelInfo {
  name: string;
  unit: string;
  low: number;
  high: number;
}
export interface StreamInfo {
  name: string;
  media: string;
}
/** What the page knows about its robot, for every robot. */
export interface RobotFacts {
  compact: CompactLayout | null;
  /** How commands are packed; a portal of before does not say. */
  packed?: CommandLayout;
  commands: CommandSpec[];
  labels: Record<string, string>;
  /** Plain words for the robot's own, as names of joints and modes; a portal of before does not say. */
  words?: Record<string, string>;
  settings: string[];
  /** The settings of staff that consoles may see. */
  set: Record<string, unknown>;
  names: string[];
  channels: ChannelInfo[];
  pose: { name: string; unit: string }[];
  streams: StreamInfo[];
  cameras: number;
  video: Coding;
}
export interface Answer {
  t: "answer";
  to: string;
  seq?: number;
  ok: boolean;
  text: string;
  code: string;
  id?: number;
  state?: string;
  grant?: number;
}
/** How many have cheered for the holder of that grant. */
export interface CheerCount {
  t: "cheers";
  grant: number;
  count: number;
}
export interface TraceLine {
  t: "trace";
  direction: string;
  hex: string;
  words: string;
  at_ms: number;
  resent: number;
  broken: number;
}
/** A remark on a step of a program before anything moves. `at_s`: when the step begins; `refuses`: it will not run. */
export interface Judgement {
  step: number;
  at_s: number;
  text: string;
  refuses: boolean;
}
/**
 * Where a target would lead: the joints (rad, m) at its end, the paths of the joints and of the tool (m), the duration (s).
 * `poses`: the body's poses along the motion in the robot's own frame (from here, ahead, left); `times`: when (s).
 */
export interface PlanAnswer {
  t: "plan";
  n: number;
  ok: boolean;
  text: string;
  joints?: number[];
  tool?: number[][];
  path?: number[][];
  steps?: number[];
  seconds?: number;
  poses?: number[][];
  times?: number[];
  judgements?: Judgement[];
}
export type Message =
  | Snapshot
  | Answer
  | TraceLine
  | PlanAnswer
  | ({ t: "command" } & CommandInfo)
  | { t: "notice"; text: string; level: string }
  | { t: "store"; text: string }
  | { t: "watchers"; count: number }
  | CheerCount
  | { t: "pong"; n: number; now_ms: number; link: boolean };
