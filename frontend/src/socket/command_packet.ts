/** Writes a command in few bytes, for slow lines (robots/kit/contract/command_packet.py). */

/** How an argument is packed: name, range, the value of code 0, step, bits (0: not at all), whether it must be given. */
type Field = [name: string, low: number, high: number, first: number, step: number, bits: number, required: boolean];

/** The layout of a robot's commands: its digest, and each kind in the order of the spec with its arguments. */
export interface CommandLayout {
  mark: number;
  kinds: [kind: string, fields: Field[]][];
}
export interface CommandMessage {
  kind: string;
  args: Record<string, unknown>;
  seq: number;
  seen?: number;
}

const TYPE = 8,
  HOLD = 10,
  PING = 11,
  MOST_INDEX = 127,
  MOST_SEQ = 2 ** 16 - 1,
  SEEN_BITS = 22,
  SEEN_MS = 3600 * 1000; // an older picture is told in JSON

type Put = (value: number, count: number) => void;

function written(write: (put: Put) => boolean): Uint8Array<ArrayBuffer> | null {
  let bits = "";
  if (!write((value, count) => void (bits += value.toString(2).padStart(count, "0")))) return null;
  return Uint8Array.from({ length: Math.ceil(bits.length / 8) }, (_, i) => parseInt(bits.slice(8 * i, 8 * i + 8).padEnd(8, "0"), 2));
}

/** Write the type, the digest, the number of the kind and `seq`. Returns the fields of the kind; null if it has no number. */
function begin(put: Put, type: number, layout: CommandLayout, kind: string, seq: number, args: object): Field[] | null {
  const index = layout.kinds.findIndex(([name]) => name === kind),
    fields = layout.kinds[index]?.[1];
  if (!fields || index > MOST_INDEX || seq > MOST_SEQ || seq < 1) return null;
  if (Object.keys(args).some((name) => !fields.some(([known]) => known === name))) return null;
  put(type, 8);
  put(layout.mark, 8);
  put(index, 7);
  put(seq, 16);
  return fields;
}

/** Write an argument; `given`: it always is. Returns whether it fits. */
function putField(put: Put, [, low, high, first, step, count]: Field, value: unknown, given: boolean): boolean {
  if (!given) put(value === undefined ? 0 : 1, 1);
  if (value === undefined && !given) return true;
  if (typeof value !== "number" || !(value >= low && value <= high) || !count) return false;
  const code = Math.round((value - first) / step);
  if (code < 0 || code >= 2 ** count) return false;
  if (step === 1 && first + code !== value) return false; // a whole number is sent as it is, or refused by the server
  put(code, count);
  return true;
}

/** Return the packet of a command; null if it has to be sent as JSON. `nowMs`: server time. */
export function packCommand(
  layout: CommandLayout,
  { kind, args, seq, seen = 0 }: CommandMessage,
  nowMs: number,
): Uint8Array<ArrayBuffer> | null {
  if (seen && (nowMs - seen > SEEN_MS || seen > nowMs)) return null;
  return written((put) => {
    const fields = begin(put, TYPE, layout, kind, seq, args);
    if (!fields) return false;
    put(seen ? 1 : 0, 1);
    if (seen) put(Math.round(seen) % 2 ** SEEN_BITS, SEEN_BITS);
    return fields.every((field) => putField(put, field, args[field[0]], field[6]));
  });
}

/** Return the packet of a keep-alive of a held motion, or of its release; null if it has to be sent as JSON. */
export function packHold(
  layout: CommandLayout,
  kind: string,
  { t, seq, args = {} }: { t: string; seq: number; args?: Record<string, number> },
): Uint8Array<ArrayBuffer> | null {
  return written((put) => {
    const fields = begin(put, HOLD, layout, kind, seq, args),
      held = t === "keep";
    if (!fields) return false;
    put(held ? 1 : 0, 1);
    return !held || fields.every((field) => putField(put, field, args[field[0]], false));
  });
}

/** Return the packet of a ping; null if it has to be sent as JSON. */
export function packPing(n: number): Uint8Array<ArrayBuffer> | null {
  return n <= MOST_SEQ ? Uint8Array.of(PING, n >> 8, n & 255) : null;
}
