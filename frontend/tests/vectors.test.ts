/** What stands in Python and in TypeScript gives the same for the same vectors (tests/unit/test_vectors.py). */
import assert from "node:assert/strict";
import { test } from "node:test";
import { Matrix4 } from "three";
import { type Description, forward, type Map2, onSand, reach, target } from "../../robots/kit/drivers/mercury/console/scara.ts";
import { parse, type Step } from "../../robots/kit/drivers/pa10/console/program_text.ts";
import { understood } from "../../robots/kit/drivers/pa10/console/terminal_lines.ts";
import { numbersOf } from "../src/arm/pose.ts";
import type { CompactLayout } from "../src/socket/compact_state.ts";
import { type Box, objectsAfter, type Placed } from "../src/socket/objects.ts";
import { decode } from "../src/socket/decoder.ts";
import type { PicturePacket, SoundPacket, StatePacket, StreamPacket, VideoPacket } from "../src/socket/packets.ts";
import { momentOf, unpackSlice } from "../src/replay/slices.ts";
import { ByteStreams } from "../src/socket/byte_streams.ts";
import { isShort, ShortHeads } from "../src/socket/short_heads.ts";
import { VideoChain } from "../src/media/video_chain.ts";
import { FINAL, STAGES } from "../src/socket/stages.ts";
import { parseTask, printTask } from "../src/widgets/task_text.ts";
import { bytesOf, vectorsOf } from "./helpers.ts";

const near = (found: readonly number[], wanted: readonly number[]): void =>
  wanted.forEach((value, i) => assert.ok(Math.abs((found[i] ?? NaN) - value) < 1e-8, `${found} is not ${wanted}`));

interface Plane extends Description {
  forward: { q: number[]; elbow: number[]; tool: number[] }[];
  places: { x: number; y: number; allowed: boolean; elbow: number[] | null }[];
  clicks: { map: Map2; pose: number[]; u: number; v: number; width: number; height: number; target: number[] }[];
}

test("Mercury's plane: elbow, tool, the sand's edge, what a click means", () => {
  const plane = vectorsOf<Plane>("mercury_plane");
  for (const { q, elbow, tool } of plane.forward) {
    near(forward(plane, q).elbow, elbow);
    near(forward(plane, q).tool, tool);
  }
  for (const { x, y, allowed, elbow } of plane.places) {
    assert.equal(onSand(plane, x, y) && reach(plane, x, y) !== null, allowed, `${x}, ${y}`);
    if (elbow) near(reach(plane, x, y)?.elbow ?? [], elbow);
  }
  for (const c of plane.clicks) near(target(c.map, c.pose, c.u, c.v, c.width, c.height), c.target);
});

/** A tree of steps as the arm runs it: repetitions written out. */
function flat(steps: Step[]): (string | number)[][] {
  return steps.flatMap((step): (string | number)[][] => {
    const speed = "speed" in step && step.speed !== undefined ? [step.speed] : [];
    switch (step.do) {
      case "joints":
        return [["j", ...step.values, ...speed]];
      case "pose":
        return [[step.straight ? "l" : "k", ...step.values, ...speed]];
      case "grip":
        return [["g", step.closed ? 1 : 0]];
      case "wait":
        return [["d", step.seconds]];
      case "repeat":
        return Array.from({ length: step.times }, () => flat(step.steps)).flat();
      case "line":
        return [step.text.split(/\s+/).map((word, i) => (i ? Number(word) : word))];
    }
  });
}

test("the museum arm's programs are read as the arm reads them, and refused in the same line", () => {
  for (const one of vectorsOf<{ text: string; steps?: (string | number)[][]; refused?: number | null }[]>("pa10_programs")) {
    if (one.steps) assert.deepEqual(flat(parse(one.text)), one.steps, one.text);
    const why = one.refused ? new RegExp(`^Error: Line ${one.refused}: `) : /^Error: (?!Line)/;
    if (!one.steps) assert.throws(() => parse(one.text), why, JSON.stringify(one.text));
  }
});

test("tasks are read as the arm's driver reads them, written alike, and refused with the same sentence", () => {
  for (const { text, written, refused } of vectorsOf<{ text: string; written?: string; refused?: string }[]>("tasks")) {
    if (written === undefined) assert.throws(() => parseTask(text), { message: refused }, JSON.stringify(text));
    else {
      assert.equal(printTask(parseTask(text)), written, JSON.stringify(text));
      assert.deepEqual(parseTask(written), parseTask(text));
    }
  }
});

test("a typed line of the museum arm stands for the command that sends it, and what the arm refuses is refused", () => {
  const axes = ["S1", "S2", "E1", "E2", "W1", "W2"];
  type Line = { line: string; kind: string; args: Record<string, number> };
  const known = vectorsOf<{ understood: Line[]; refused: string[] }>("pa10_lines");
  for (const { line, kind, args } of known.understood) {
    const found = understood(line, axes);
    assert.deepEqual([found.kind, Object.keys(found.args)], [kind, Object.keys(args)], line);
    near(Object.values(found.args) as number[], Object.values(args));
  }
  for (const line of known.refused) assert.throws(() => understood(line, axes), Error, line);
});

test("roll, pitch and yaw are those of Python", () => {
  for (const { matrix, pose } of vectorsOf<{ matrix: number[][]; pose: number[] }[]>("poses"))
    near(numbersOf(new Matrix4().fromArray(matrix.flat()).transpose()), pose);
});

interface Pictured {
  what: string;
  hex: string;
  number: number;
  at_ms: number;
  still: number;
  joints: number[];
  pose: number[];
  twist: number[];
  jpeg: string;
  camera: number;
}

test("a picture's packet is read as Python packs it, and one that is cut off is none", async () => {
  for (const one of vectorsOf<Pictured[]>("picture_packets")) {
    const bytes = bytesOf(one.hex),
      found = decode(bytes.buffer) as PicturePacket;
    assert.deepEqual(
      [found.camera, found.number, found.atMs, found.still, found.joints],
      [one.camera, one.number % 2 ** 32, one.at_ms, one.still, [...one.joints, ...one.pose, ...one.twist]],
      one.what,
    );
    assert.equal(Buffer.from(await found.jpeg.arrayBuffer()).toString("hex"), one.jpeg, one.what);
    const head = bytes.length - one.jpeg.length / 2;
    for (let length = 0; length <= head; length++) assert.equal(decode(bytes.slice(0, length).buffer), null, `${one.what}, cut off`);
  }
});

test("slices of a recording are taken apart as Python writes them; a packet that nobody knows is left out", () => {
  type Message = { after_ms: number; topic: string; hex: string };
  const { slices, messages } = vectorsOf<{ slices: string[]; messages: Message[] }>("recording_slices");
  const items = slices.flatMap((hex) => unpackSlice(bytesOf(hex).buffer));
  const known = messages.filter(({ hex }) => !hex.startsWith("63"));
  assert.equal(known.length, messages.length - 1);
  const times = items.map(({ at }) => at),
    wanted = known.map(({ after_ms }) => after_ms);
  assert.deepEqual(times, wanted);
  for (const [i, { hex, topic }] of known.entries()) {
    const sent = decode(bytesOf(hex).buffer)!,
      { packet } = items[i]!;
    assert.deepEqual({ ...packet, jpeg: null }, { ...sent, jpeg: null }, topic);
  }
  const end = momentOf(items, 1e9);
  const pictures = [...end.pictures].map(([camera, { at }]) => `${camera} ${at}`);
  assert.deepEqual([end.state?.at, ...pictures], [10_100, "0 990", "2 7500"]);
  const chain = end.chains.get(0)?.map(({ at }) => at);
  assert.deepEqual(chain, [900, 5000]);
});

test("every state of a command has words, and the same ones are final", () => {
  const known = vectorsOf<{ states: string[]; final: string[] }>("command_states");
  assert.deepEqual([...FINAL].sort(), known.final);
  for (const state of known.states) assert.ok(STAGES[state], state);
});

interface Packet {
  what: string;
  hex: string;
  number: number;
  at_ms: number;
  moving: boolean;
  stopped: boolean;
  mode: string;
  joints: number[];
  velocities: number[];
  torques: number[];
  channels: string[];
  values: (number | null)[];
  twist: number[];
}

test("a state packet is read as Python packs it, and one that is cut off is none", () => {
  for (const one of vectorsOf<Packet[]>("state_packets")) {
    const bytes = bytesOf(one.hex);
    const found = decode(bytes.buffer) as StatePacket;
    assert.deepEqual(
      [found.number, found.atMs, found.moving, found.stopped, found.mode],
      [one.number, one.at_ms, one.moving, one.stopped, one.mode],
      one.what,
    );
    assert.deepEqual([found.joints, found.velocities, found.torques], [one.joints, one.velocities, one.torques], one.what);
    const values = found.values.map((v) => (Number.isNaN(v) ? null : v));
    assert.deepEqual(values, [...one.values, ...one.twist], one.what);
    const whole = bytes.length - Buffer.from(one.mode).length;
    if (one.values.length) assert.equal(decode(bytes.slice(0, whole - 1).buffer), null, `${one.what}, cut off`);
  }
});

interface Compacted {
  what: string;
  layout: CompactLayout;
  hex: string;
  at_ms: number;
  near_ms: number;
  moving: boolean;
  stopped: boolean;
  joints: number[];
  mode: string;
  told: Record<string, number>;
}

test("compact states are read as Python writes them, and nothing shorter or of another layout", () => {
  const all = vectorsOf<Compacted[]>("compact_states");
  for (const one of all) {
    const bytes = bytesOf(one.hex);
    const found = decode(bytes.buffer, one.layout, one.near_ms) as StatePacket;
    assert.deepEqual([found.atMs, found.moving, found.stopped, found.mode], [one.at_ms, one.moving, one.stopped, one.mode], one.what);
    assert.equal(found.joints.length, one.layout.joints, one.what);
    const wanted = [...one.joints, ...Object.values(one.told)];
    const told = [...found.joints, ...found.values].filter((value) => !Number.isNaN(value));
    assert.equal(told.length, wanted.length, one.what);
    const steps = one.layout.scales.map(([, step]) => step);
    told.forEach((value, i) => assert.ok(Math.abs(value - wanted[i]!) <= Math.max(...steps) / 2 + 1e-9, one.what));
    const whole = bytes.length - (one.layout.modes.includes(one.mode) ? 0 : Buffer.from(one.mode).length);
    for (let length = 0; length < whole; length++)
      assert.equal(decode(bytes.slice(0, length).buffer, one.layout, one.near_ms), null, one.what);
    for (const { layout } of all) if (layout.mark !== one.layout.mark) assert.equal(decode(bytes.buffer, layout, one.near_ms), null);
    assert.equal(decode(bytes.buffer), null, `${one.what}, without a layout`);
  }
});

interface Streamed {
  what: string;
  shown: Record<string, string[]>;
  packets: { hex: string; stream: number; run: number; number: number; at_ms: number; key: boolean; data: string }[];
}

test("packets of byte streams are read as Python packs them, and deltas follow their key packet alone", () => {
  const hex = (data: Uint8Array): string => Buffer.from(data).toString("hex");
  for (const one of vectorsOf<Streamed[]>("stream_packets")) {
    const streams = new ByteStreams(["first", "second", "third"]);
    for (const packet of one.packets) {
      const bytes = bytesOf(packet.hex);
      const found = decode(bytes.buffer) as StreamPacket;
      assert.deepEqual(
        [found.stream, found.run, found.number, found.atMs, found.key, hex(found.data)],
        [packet.stream, packet.run, packet.number, packet.at_ms, packet.key, packet.data],
        one.what,
      );
      assert.equal(decode(bytes.slice(0, 15).buffer), null, `${one.what}, cut off`);
      streams.take(found);
    }
    for (const [stream, shown] of Object.entries(one.shown)) {
      const chain = streams.of(["first", "second", "third"][Number(stream)]!).map(({ data }) => hex(data));
      assert.deepEqual(chain, shown, one.what);
    }
  }
});

test("deltas with short heads are whole again, after what they follow alone", () => {
  const hex = (data: Uint8Array): string => Buffer.from(data).toString("hex");
  for (const one of vectorsOf<{ what: string; packets: (Streamed["packets"][0] & { sent: string })[] }[]>("short_heads")) {
    const heads = new ShortHeads(),
      late = new ShortHeads();
    for (const { sent, ...packet } of one.packets) {
      const { buffer } = bytesOf(sent),
        short = isShort(bytesOf(sent)[0]);
      const found = heads.note(short ? heads.take(buffer) : decode(buffer)) as StreamPacket;
      assert.deepEqual(
        [found.stream, found.run, found.number, found.atMs, found.key, hex(found.data)],
        [packet.stream, packet.run, packet.number, packet.at_ms, packet.key, packet.data],
        one.what,
      );
      if (short) assert.equal(late.take(buffer), null, "what it follows did not come");
      assert.equal(late.take(buffer.slice(0, 2)), null, "cut off");
    }
    heads.clear();
    for (const { sent } of one.packets) if (isShort(bytesOf(sent)[0])) assert.equal(heads.take(bytesOf(sent).buffer), null);
  }
});

interface Filmed {
  what: string;
  packets: {
    hex: string;
    camera: number;
    run: number;
    number: number;
    follows: number | null;
    at_ms: number;
    still: number;
    data: string;
    taken: boolean;
  }[];
}

test("packets of video are read as Python packs them, and each is decoded only after the one that it changes", () => {
  for (const one of vectorsOf<Filmed[]>("video_packets")) {
    const chains = new Map<number, VideoChain>();
    for (const packet of one.packets) {
      const bytes = bytesOf(packet.hex);
      const found = decode(bytes.buffer) as VideoPacket;
      assert.deepEqual(
        [found.camera, found.run, found.number, found.follows, found.atMs, found.still, Buffer.from(found.coded).toString("hex")],
        [packet.camera, packet.run, packet.number, packet.follows, packet.at_ms, packet.still, packet.data],
        one.what,
      );
      for (let length = 0; length <= 20; length++) assert.equal(decode(bytes.slice(0, length).buffer), null, `${one.what}, cut off`);
      const chain = chains.get(packet.camera) ?? new VideoChain();
      chains.set(packet.camera, chain);
      assert.equal(chain.take(found), packet.taken, one.what);
    }
  }
});

test("packets of sound are read as Python packs them, and nothing else is read", () => {
  type Heard = { what: string; hex: string; run: number; number: number; at_ms: number; ms: number; data: string; said: string };
  const { read: good, refused } = vectorsOf<{ read: Heard[]; refused: { what: string; hex: string }[] }>("sound_packets");
  for (const one of good) {
    const bytes = bytesOf(one.hex),
      found = decode(bytes.buffer) as SoundPacket;
    assert.deepEqual(
      [found.run, found.number, found.atMs, found.ms, Buffer.from(found.opus).toString("hex"), found.said],
      [one.run, one.number, one.at_ms, one.ms, one.data, one.said],
      one.what,
    );
    for (let length = 0; length <= 16; length++) assert.equal(decode(bytes.slice(0, length).buffer), null, `${one.what}, cut off`);
  }
  for (const one of refused) {
    const bytes = bytesOf(one.hex),
      found = decode(bytes.buffer);
    assert.ok(found === null || !("opus" in found), one.what);
  }
});

test("objects are read as Python packs them, deltas change what was known, and nothing else is read", () => {
  type Packed = { what: string; key: boolean; hex: string; read: Record<string, number[]>; held?: string[] };
  const { box, packets } = vectorsOf<{ box: Box; packets: Packed[] }>("object_packets");
  let known = new Map<number, Placed>();
  for (const { what, key, hex, read: wanted, held = [] } of packets) {
    const bytes = bytesOf(hex),
      before = new Map(known);
    const after = objectsAfter(known, bytes, key, box)!;
    assert.deepEqual(known, before, what);
    assert.deepEqual([...after.keys()].sort((a, b) => a - b).map(String), Object.keys(wanted), what);
    for (const [number, { place, rotation }] of after) near([...place, ...rotation], wanted[number]!);
    assert.deepEqual(
      [...after].filter(([, one]) => one.held).map(([number]) => String(number)),
      held,
      what,
    );
    if (bytes.length) assert.equal(objectsAfter(known, bytes.subarray(1), key, box), null, what);
    known = after;
  }
  const beyond = new Uint8Array(12).fill(255);
  beyond[0] = 1; // x is no longer all ones, the rest is
  beyond[1] = 0;
  assert.equal(objectsAfter(known, beyond, false, box), null);
});
