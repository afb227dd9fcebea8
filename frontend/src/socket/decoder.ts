/** Decodes the binary packets of the socket. */
import { compactState } from "./compact_state.ts";
import { jointPath } from "./joint_path.ts";
import type { CompactLayout, Packet, SoundPacket, VideoPacket } from "./packets.ts";

const STATE_HEAD = 16;
const STREAM_HEAD = 16;
const PICTURE_HEAD = 19;
const VIDEO_HEAD = 20;
const SOUND_HEAD = 16,
  SOUND_MOST = 4000,
  SOUND_LONGEST_MS = 120;
const words = new TextDecoder();
const strict = new TextDecoder("utf-8", { fatal: true, ignoreBOM: true });

function floats(view: DataView, at: number, count: number): number[] {
  return Array.from({ length: count }, (_, i) => view.getFloat32(at + 4 * i, true));
}

function video(view: DataView<ArrayBuffer>): VideoPacket {
  const number = view.getUint32(4, true),
    back = view.getUint8(3);
  return {
    camera: view.getUint8(1),
    run: view.getUint8(2),
    follows: back ? (number - back) >>> 0 : null,
    number,
    atMs: Number(view.getBigInt64(8, true)),
    still: view.getUint32(16, true),
    coded: new Uint8Array(view.buffer, VIDEO_HEAD),
  };
}

function sound(view: DataView<ArrayBuffer>): SoundPacket | null {
  const ms = view.getUint8(1),
    rest = new Uint8Array(view.buffer, SOUND_HEAD),
    none = new Uint8Array(0);
  if (!rest.length || rest.length > SOUND_MOST || ms > SOUND_LONGEST_MS) return null;
  try {
    return {
      run: view.getUint8(2),
      number: view.getUint32(4, true),
      atMs: Number(view.getBigInt64(8, true)),
      ms,
      opus: ms ? rest : none,
      said: ms ? "" : strict.decode(rest),
    };
  } catch {
    return null; // the sentence is not UTF-8
  }
}

/**
 * Decode a binary packet; null for one that is too short or of an unknown type. For compact states and paths `layout` is the
 * robot's and `nearMs` a server time near theirs.
 */
export function decode(data: ArrayBuffer, layout: CompactLayout | null = null, nearMs = 0): Packet | null {
  const view = new DataView(data);
  if (data.byteLength > 0 && view.getUint8(0) >= 128) return layout && compactState(new Uint8Array(data), layout, nearMs);
  if (data.byteLength > 0 && view.getUint8(0) === 6) return layout && jointPath(new Uint8Array(data), layout, nearMs);
  const type = data.byteLength >= STATE_HEAD ? view.getUint8(0) : 0;
  if (type === 3)
    return {
      stream: view.getUint8(2),
      key: (view.getUint8(1) & 1) !== 0,
      run: view.getUint8(3),
      number: view.getUint32(4, true),
      atMs: Number(view.getBigInt64(8, true)),
      data: new Uint8Array(data, STREAM_HEAD),
    };
  if (type === 4) return data.byteLength > VIDEO_HEAD ? video(view) : null;
  if (type === 5) return sound(view);
  if (type === 1) {
    const flags = view.getUint8(1),
      count = view.getUint8(14),
      rows = view.getUint8(15);
    const rest = STATE_HEAD + 4 * count * rows;
    const told = flags & 4 && data.byteLength > rest ? view.getUint8(rest) : 0;
    const end = flags & 4 ? rest + 1 + 4 * told : rest;
    if (data.byteLength < end) return null;
    const row = (i: number): number[] => (i < rows ? floats(view, STATE_HEAD + 4 * count * i, count) : []);
    return {
      moving: (flags & 1) !== 0,
      stopped: (flags & 2) !== 0,
      number: view.getUint32(2, true),
      atMs: Number(view.getBigInt64(6, true)),
      joints: row(0),
      velocities: row(1),
      torques: row(2),
      values: floats(view, rest + 1, told),
      mode: words.decode(data.slice(end)),
    };
  }
  if (type === 2 && data.byteLength > PICTURE_HEAD) {
    const count = view.getUint8(18),
      end = PICTURE_HEAD + 4 * count;
    if (data.byteLength <= end) return null;
    return {
      camera: view.getUint8(1),
      number: view.getUint32(2, true),
      atMs: Number(view.getBigInt64(6, true)),
      still: view.getUint32(14, true),
      joints: floats(view, PICTURE_HEAD, count),
      jpeg: new Blob([data.slice(end)], { type: "image/jpeg" }),
    };
  }
  return null;
}
