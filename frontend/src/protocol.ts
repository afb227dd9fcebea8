/** What walks over the socket: binary packets for joints and pictures, JSON for the rest. */

export interface Still {
  id: number; url: string; at_ms: number; stable: boolean; verdict: string;
  pose: number[]; joints: number[]; width: number; height: number;
  calibration: Record<string, { matrix: number[][]; z: number; theta: number; residual_mm: number }>;
}
export interface CommandInfo {
  id: number; seq: number; grant: number; kind: string; state: string; reason: string;
  at_ms: number; by?: string; result: { verdict?: string; note?: string; still?: number; stable?: boolean; picture?: string | null };
}
export interface LogInfo { id: number; author: string; text: string; at_ms: number; picture: string | null; featured: boolean }
export interface Snapshot {
  t: "snapshot"; now_ms: number; link: boolean;
  robot: { slug: string; name: string; state: string; label: string; why: string };
  stopped: boolean; operator: string | null; queue: number;
  turn: null | { id: number | null; grant: number; mine: boolean; until_ms: number | null; next_seq: number; extra: boolean; staff: boolean };
  me: {
    signed_in: boolean; name?: string; cleared: boolean; may_stop: boolean; operating: boolean; staff?: boolean; last_turn?: number | null;
    ticket: null | { state: string; ahead: number; wait_s: [number, number] | null; offer_until_ms: number | null };
  };
  still: Still | null; before: Still | null; commands: CommandInfo[]; log: LogInfo[];
}
export interface Answer { t: "answer"; to: string; seq?: number; ok: boolean; text: string; code: string; id?: number; state?: string; grant?: number }
export interface TraceLine { t: "trace"; way: string; hex: string; words: string; at_ms: number; resent: number; broken: number }
export type Message =
  | Snapshot | Answer | TraceLine
  | ({ t: "command" } & CommandInfo)
  | { t: "notice"; text: string; level: string }
  | { t: "pong"; n: number; now_ms: number; link: boolean };

export interface StatePacket { moving: boolean; stopped: boolean; number: number; atMs: number; joints: number[] }
export interface PicturePacket { number: number; atMs: number; still: number; joints: number[]; jpeg: Blob }

const SCALE = 10_000;
const HEAD = 27;

function joints(view: DataView, at: number): number[] {
  return [0, 2, 4, 6].map((o) => view.getInt16(at + o, true) / SCALE);
}

/** Decode a binary packet; null for one that is too short or of an unknown type. */
export function decode(data: ArrayBuffer): StatePacket | PicturePacket | null {
  const view = new DataView(data);
  if (data.byteLength >= 22 && view.getUint8(0) === 1) {
    const flags = view.getUint8(1);
    return {
      moving: (flags & 1) !== 0, stopped: (flags & 2) !== 0, number: view.getUint32(2, true),
      atMs: Number(view.getBigInt64(6, true)), joints: joints(view, 14),
    };
  }
  if (data.byteLength > HEAD && view.getUint8(0) === 2) {
    return {
      number: view.getUint32(1, true), atMs: Number(view.getBigInt64(5, true)), still: view.getUint32(13, true),
      joints: joints(view, 17), jpeg: new Blob([data.slice(HEAD)], { type: "image/jpeg" }),
    };
  }
  return null;
}
