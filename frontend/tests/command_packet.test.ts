/** Commands in few bytes are written as Python reads them; what does not fit is left to JSON. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { type CommandLayout, type CommandMessage, packCommand, packHold, packPing } from "../src/socket/command_packet.ts";
import { vectorsOf } from "./helpers.ts";

interface Vectors {
  layouts: Record<string, CommandLayout>;
  commands: { what: string; robot: string; command: CommandMessage; now_ms: number; hex: string | null }[];
  holds: { what: string; robot: string; kind: string; message: Parameters<typeof packHold>[2]; hex: string | null }[];
}

test("commands are packed as Python reads them, the others are sent as JSON", () => {
  const { layouts, commands } = vectorsOf<Vectors>("command_packets");
  assert.ok(commands.some(({ hex }) => hex === null) && commands.some(({ hex }) => hex !== null));
  for (const { what, robot, command, now_ms, hex } of commands) {
    const packed = packCommand(layouts[robot]!, command, now_ms);
    assert.equal(packed && Buffer.from(packed).toString("hex"), hex, what);
    if (packed) assert.ok(packed.length <= 24 && packed.length < JSON.stringify(command).length / 2, what);
  }
});

test("no text, no boolean and no number that is not finite is packed", () => {
  const { layouts, commands } = vectorsOf<Vectors>("command_packets");
  const { robot, command, now_ms } = commands[0]!;
  const [name] = Object.keys(command.args);
  for (const wrong of ["0.1", true, null, NaN, Infinity, {}])
    assert.equal(packCommand(layouts[robot]!, { ...command, args: { ...command.args, [name!]: wrong } }, now_ms), null);
  for (const seq of [0, -1, 65_536]) assert.equal(packCommand(layouts[robot]!, { ...command, seq }, now_ms), null);
});

test("keep-alives and releases are packed as Python reads them", () => {
  const { layouts, holds } = vectorsOf<Vectors>("command_packets");
  for (const { what, robot, kind, message, hex } of holds) {
    const packed = packHold(layouts[robot]!, kind, message);
    assert.equal(packed && Buffer.from(packed).toString("hex"), hex, what);
  }
});

test("a ping is packed with its number", () => {
  assert.deepEqual([...packPing(258)!], [11, 1, 2]);
  assert.equal(packPing(65_536), null);
});
