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
  MOST_INDEX = 127,
  MOST_SEQ = 2 ** 16 - 1,
  SEEN_BITS = 22,
  SEEN_MS = 3600 * 1000; // an older picture is told in JSON

/** Return the packet of a command; null if it has to be sent as JSON. `nowMs`: server time. */
export function packCommand(
  layout: CommandLayout,
  { kind, args, seq, seen = 0 }: CommandMessage,
  nowMs: number,
): Uint8Array<ArrayBuffer> | null {
  const index = layout.kinds.findIndex(([name]) => name === kind),
    fields = layout.kinds[index]?.[1];
  if (
    !fields ||
    index > MOST_INDEX ||
    seq > MOST_SEQ ||
    seq < 1 ||
    Object.keys(args).some((name) => !fields.some(([known]) => known === name))
  )
    return null;
  if (seen && (nowMs - seen > SEEN_MS || seen > nowMs)) return null;
  let bits = "";
  const put = (value: number, count: number): void => void (bits += value.toString(2).padStart(count, "0"));
  put(TYPE, 8);
  put(layout.mark, 8);
  put(index, 7);
  put(seq, 16);
  put(seen ? 1 : 0, 1);
  if (seen) put(Math.round(seen) % 2 ** SEEN_BITS, SEEN_BITS);
  for (const [name, low, high, first, step, count, required] of fields) {
    const value = args[name];
    if (!required) put(value === undefined ? 0 : 1, 1);
    if (value === undefined && !required) continue;
    if (typeof value !== "number" || !(value >= low && value <= high) || !count) return null;
    const code = Math.round((value - first) / step);
    if (code < 0 || code >= 2 ** count) return null;
    if (step === 1 && first + code !== value) return null; // a whole number is sent as it is, or refused by the server
    put(code, count);
  }
  return Uint8Array.from({ length: Math.ceil(bits.length / 8) }, (_, i) => parseInt(bits.slice(8 * i, 8 * i + 8).padEnd(8, "0"), 2));
}
