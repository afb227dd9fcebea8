/** The messages on the socket: binary packets for states and pictures, JSON for the rest. */

import { compactState } from "./compact_state.ts";
import type { Coding, CompactLayout, Packet, SoundPacket, VideoPacket } from "./packets.ts";

export type { Packet, PicturePacket, SoundPacket, StatePacket, StreamPacket, VideoPacket } from "./packets.ts";

export interface Still {
  id: number; url: string; at_ms: number; stable: boolean; verdict: string;
  /** Where the robot was: coordinates that its spec declares, joints (rad, m), and values of its channels by name. */
  pose: number[]; joints: number[]; values: Record<string, number>; width: number; height: number;
  /** The result of the robot's own calibration at that time; its console knows what it holds. */
  calibration: Record<string, unknown>;
}
export interface CommandInfo {
  id: number; seq: number; grant: number; kind: string; state: string; reason: string;
  at_ms: number; by?: string;
  /** Into which of the page's sockets it went, counted from 1; of what this page has sent. */
  over?: number;
  /** The progress of a long command; `share` is from 0 to 1, or null if the robot does not say. */
  progress?: { text?: string; share?: number | null; at_ms?: number };
  /** When the picture was taken that its sender saw, and the robot's newest then (server ms); null: not known. */
  seen_ms?: number | null; newest_ms?: number | null;
  /** What was asked and what was sent in its place, by name. */
  clamping?: Record<string, [asked: number, sent: number]>;
  result?: { verdict?: string; note?: string; still?: number; stable?: boolean; picture?: string | null };
}
export interface LogInfo { id: number; author: string; text: string; at_ms: number; picture: string | null; featured: boolean }
/** How a turn or a place ended: why, what it cost, and what is next. */
export interface EndReason { why: string; credited: string; next: string }
export interface EndedTurn extends EndReason { turn: number; ended_ms: number; own: boolean; written: boolean }
export interface StopShown { confirmed: boolean; since_ms: number | null; rests_by_ms: number | null }
/** An open job of the robot, as everybody sees it: `ahead` requests before it, the least and greatest wait (s). */
export interface JobInfo { id: number; kind: string; state: string; args: Record<string, number>; ahead: number; wait_s: [number, number] | null }
export interface Snapshot {
  t: "snapshot"; now_ms: number; link: boolean; store: string;
  /** It is of a recording: nothing can be commanded. */
  replay?: boolean;
  robot: { slug: string; name: string; state: string; label: string; why: string; turns: boolean; simulated?: boolean };
  stopped: boolean; operator: string | null; queue: number;
  /** After a stop, jobs and the robot's own behaviour wait until staff resume them. */
  suspended: boolean;
  /** In the order in which they will be served. */
  jobs: JobInfo[];
  /** The latched stop: whether the robot confirmed that it rests, and if not, the latest time by which it rests. */
  stop: StopShown | null;
  turn: null | { id: number | null; grant: number; mine: boolean; until_ms: number | null; next_seq: number; extra: boolean; staff: boolean; wanted: boolean };
  me: {
    signed_in: boolean; name?: string; cleared: boolean; staff?: boolean; last_turn?: number | null;
    /** The last turn here, if it ended lately or has no entry in the log: why it ended, what it cost, what is next. */
    last_end?: null | EndedTurn;
    /** What this person can do now; `ask` is for jobs. */
    can: { watch: boolean; drive: boolean; ask: boolean; stop: boolean };
    ticket: null | { state: string; ahead: number; wait_s: [number, number] | null; offer_until_ms: number | null };
  };
  still: Still | null; before: Still | null; commands: CommandInfo[]; log: LogInfo[];
}
export interface ArgumentInfo { name: string; unit: string; low: number; high: number; required: boolean; text: boolean; whole: boolean; label: string; help: string }
export interface CommandSpec { kind: string; label: string; lane: "motion" | "config"; arguments: ArgumentInfo[]; held: boolean; steered: boolean; replaceable: boolean }
/** A value beside the joints, as a battery's charge: its unit and its usual range. */
export interface ChannelInfo { name: string; unit: string; low: number; high: number }
export interface StreamInfo { name: string; media: string }
/** What the page knows about its robot, for every robot. */
export interface RobotFacts { compact: CompactLayout | null; commands: CommandSpec[]; labels: Record<string, string>; settings: string[]; /** What staff have set, as far as consoles are told it. */ set: Record<string, unknown>; names: string[]; channels: ChannelInfo[]; pose: { name: string; unit: string }[]; streams: StreamInfo[]; cameras: number; video: Coding }
export interface Answer { t: "answer"; to: string; seq?: number; ok: boolean; text: string; code: string; id?: number; state?: string; grant?: number }
export interface TraceLine { t: "trace"; direction: string; hex: string; words: string; at_ms: number; resent: number; broken: number }
/** What is to say of a step of a program before anything moves: `at_s`, when it begins; `refuses`: it will not run. */
export interface Judgement { step: number; at_s: number; text: string; refuses: boolean }
/**
 * Where a target would lead: joints (rad, m) at its end, path of joints and of the tool (m), duration (s). `poses`: of the
 * body along the motion in the robot's own frame (from here, ahead, left), each at its time (s).
 */
export interface PlanAnswer { t: "plan"; n: number; ok: boolean; text: string; joints?: number[]; tool?: number[][]; path?: number[][]; steps?: number[]; seconds?: number; poses?: number[][]; times?: number[]; judgements?: Judgement[] }
export type Message =
  | Snapshot | Answer | TraceLine | PlanAnswer
  | ({ t: "command" } & CommandInfo)
  | { t: "notice"; text: string; level: string }
  | { t: "store"; text: string }
  | { t: "watchers"; count: number }
  | { t: "pong"; n: number; now_ms: number; link: boolean };

const STATE_HEAD = 16;
const STREAM_HEAD = 16;
const PICTURE_HEAD = 19;
const VIDEO_HEAD = 20;
const SOUND_HEAD = 16, SOUND_MOST = 4000, SOUND_LONGEST_MS = 120;
const words = new TextDecoder();
const strict = new TextDecoder("utf-8", { fatal: true, ignoreBOM: true });

function floats(view: DataView, at: number, count: number): number[] {
  return Array.from({ length: count }, (_, i) => view.getFloat32(at + 4 * i, true));
}

function video(view: DataView<ArrayBuffer>): VideoPacket {
  const number = view.getUint32(4, true), back = view.getUint8(3);
  return {
    camera: view.getUint8(1), run: view.getUint8(2), follows: back ? (number - back) >>> 0 : null, number,
    atMs: Number(view.getBigInt64(8, true)), still: view.getUint32(16, true), coded: new Uint8Array(view.buffer, VIDEO_HEAD),
  };
}

function sound(view: DataView<ArrayBuffer>): SoundPacket | null {
  const ms = view.getUint8(1), rest = new Uint8Array(view.buffer, SOUND_HEAD), none = new Uint8Array(0);
  if (!rest.length || rest.length > SOUND_MOST || ms > SOUND_LONGEST_MS) return null;
  try {
    return {
      run: view.getUint8(2), number: view.getUint32(4, true), atMs: Number(view.getBigInt64(8, true)), ms,
      opus: ms ? rest : none, said: ms ? "" : strict.decode(rest),
    };
  } catch {
    return null; // a sentence that is no text
  }
}

/**
 * Decode a binary packet; null for one that is too short or of an unknown type. For compact states `layout` is the
 * robot's and `nearMs` a server time near theirs.
 */
export function decode(data: ArrayBuffer, layout: CompactLayout | null = null, nearMs = 0): Packet | null {
  const view = new DataView(data);
  if (data.byteLength > 0 && view.getUint8(0) >= 128) return layout && compactState(new Uint8Array(data), layout, nearMs);
  const type = data.byteLength >= STATE_HEAD ? view.getUint8(0) : 0;
  if (type === 3)
    return {
      stream: view.getUint8(2), key: (view.getUint8(1) & 1) !== 0, run: view.getUint8(3), number: view.getUint32(4, true),
      atMs: Number(view.getBigInt64(8, true)), data: new Uint8Array(data, STREAM_HEAD),
    };
  if (type === 4) return data.byteLength > VIDEO_HEAD ? video(view) : null;
  if (type === 5) return sound(view);
  if (type === 1) {
    const flags = view.getUint8(1), count = view.getUint8(14), rows = view.getUint8(15);
    const rest = STATE_HEAD + 4 * count * rows;
    const told = flags & 4 && data.byteLength > rest ? view.getUint8(rest) : 0;
    const end = flags & 4 ? rest + 1 + 4 * told : rest;
    if (data.byteLength < end) return null;
    const row = (i: number): number[] => (i < rows ? floats(view, STATE_HEAD + 4 * count * i, count) : []);
    return {
      moving: (flags & 1) !== 0, stopped: (flags & 2) !== 0, number: view.getUint32(2, true),
      atMs: Number(view.getBigInt64(6, true)), joints: row(0), velocities: row(1), torques: row(2),
      values: floats(view, rest + 1, told),
      mode: words.decode(data.slice(end)),
    };
  }
  if (type === 2 && data.byteLength > PICTURE_HEAD) {
    const count = view.getUint8(18), end = PICTURE_HEAD + 4 * count;
    if (data.byteLength <= end) return null;
    return {
      camera: view.getUint8(1), number: view.getUint32(2, true), atMs: Number(view.getBigInt64(6, true)),
      still: view.getUint32(14, true), joints: floats(view, PICTURE_HEAD, count),
      jpeg: new Blob([data.slice(end)], { type: "image/jpeg" }),
    };
  }
  return null;
}
