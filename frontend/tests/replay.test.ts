/** A recording's slices and story: what was known at a moment, back and forth. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { momentOf, Slices, unpack } from "../src/replay/slices.ts";
import { type Index, Story } from "../src/replay/story.ts";

function stream(at: number, key: boolean, number: number): Uint8Array {
  const packet = new Uint8Array(17), view = new DataView(packet.buffer);
  packet.set([3, key ? 1 : 0, 0, 5]);
  view.setUint32(4, number, true);
  packet[16] = number;
  return packet;
}

function state(number: number): Uint8Array {
  const packet = new Uint8Array(16), view = new DataView(packet.buffer);
  packet[0] = 1;
  packet[15] = 1;
  view.setUint32(2, number, true);
  return packet;
}

function picture(number: number): Uint8Array {
  const packet = new Uint8Array(21), view = new DataView(packet.buffer);
  packet[0] = 2;
  view.setUint32(2, number, true);
  return packet;
}

function slice(...parts: [number, Uint8Array][]): ArrayBuffer {
  const whole = parts.flatMap(([at, packet]) => {
    const head = new Uint8Array(8), view = new DataView(head.buffer);
    view.setUint32(0, packet.length, true);
    view.setUint32(4, at, true);
    return [...head, ...packet];
  });
  return new Uint8Array(whole).buffer;
}

const DATA = slice(
  [0, stream(0, true, 1)], [100, state(1)], [200, stream(200, false, 2)], [300, picture(1)], [900, stream(900, true, 3)],
  [950, state(2)], [980, new Uint8Array([99, 1])], [990, picture(2)],
);

test("a slice is taken apart; what is not understood is left out, and a part that is cut off too", () => {
  assert.deepEqual(unpack(DATA).map(({ at }) => at), [0, 100, 200, 300, 900, 950, 990]);
  assert.equal(unpack(DATA.slice(0, DATA.byteLength - 1)).length, 6);
  assert.deepEqual(unpack(new ArrayBuffer(0)), []);
});

test("a moment is the newest of everything, and a stream since its key packet", () => {
  const items = unpack(DATA);
  const numbers = (at: number): unknown[] => {
    const { state: told, pictures, chains } = momentOf(items, at);
    const of = (item: { packet: { number: number } } | undefined | null): number | undefined => item?.packet.number;
    return [of(told), of(pictures.get(0)), (chains.get(0) ?? []).map(({ packet }) => packet.number)];
  };
  assert.deepEqual(numbers(250), [1, 1, [1, 2]], "before its first picture a camera shows that one");
  assert.deepEqual(numbers(940), [1, 1, [3]]);
  assert.deepEqual(numbers(1000), [2, 2, [3]]);
  assert.deepEqual(numbers(50), [1, 1, [1]], "before the first state it is shown");
});

test("slices are read once, from the earliest that is needed, and again after a failure", async () => {
  const asked: string[] = [];
  let fails = true;
  globalThis.fetch = ((address: string) => {
    const number = asked.push(address);
    return Promise.resolve(new Response(fails ? "" : DATA, { status: fails ? 503 : 200 }));
  }) as typeof fetch;
  const slices = new Slices("/r/1/", [0, 0, 1]);
  await assert.rejects(slices.until(11_000));
  fails = false;
  asked.length = 0;
  assert.equal((await slices.until(11_000)).length, 14);
  assert.equal((await slices.until(7000)).length, 14);
  assert.deepEqual(asked.sort(), ["/r/1/0.bin", "/r/1/1.bin", "/r/1/2.bin"]);
  assert.deepEqual(await slices.read(3), []);
});

const stage = (after_ms: number, id: number, state: string, more: object = {}): Index["commands"][number] => ({
  id, seq: id, grant: 1, kind: "up", state, reason: "", at_ms: 0, result: {}, after_ms, ...more,
});
const INDEX: Index = {
  began_ms: 1000, ended_ms: 9000, needs: [0, 0], cameras: [0], pictures: 2,
  commands: [
    stage(100, 1, "queued", { args: { x: 1 }, by: "ada" }), stage(300, 1, "completed"), stage(350, 1, "sent"),
    stage(500, 2, "queued"), stage(700, 2, "failed", { reason: "It slipped." }),
  ],
  events: [{ after_ms: 600, what: "gap", text: "A gap.", level: "warning" }],
};

test("what is known of commands at a moment; a late stage does not take an end back", () => {
  const story = new Story(INDEX, { index: "", slices: "", slug: "r", name: "R", who: "ada" });
  const known = (at: number): string[] => story.snapshot(at, false).commands.map(({ id, state }) => `${id} ${state}`);
  assert.deepEqual([0, 200, 400, 600, 800].map(known), [[], ["1 queued"], ["1 completed"], ["2 queued", "1 completed"], ["2 failed", "1 completed"]]);
  const { me, jobs, replay, operator } = story.snapshot(200, true);
  assert.deepEqual([replay, operator, jobs[0]?.args], [true, "ada", { x: 1 }]);
  assert.deepEqual(me.can, { watch: true, drive: false, ask: false, stop: false });
  assert.deepEqual(story.marks().map(({ at, bad }) => [at, bad]), [[100, false], [500, false], [600, true], [700, true]]);
  assert.deepEqual(story.between(500, 700).commands.map(({ state }) => state), ["failed"]);
});

test("of many slices that a moment needs, four are asked for at once", async () => {
  const before = globalThis.fetch, asked: string[] = [];
  let now = 0, most = 0;
  globalThis.fetch = (async (address: string) => {
    const number = asked.push(address);
    most = Math.max(most, ++now);
    await new Promise((done) => setTimeout(done, 1));
    now -= 1;
    return new Response(slice([number, state(number)]));
  }) as typeof fetch;
  try {
    const items = await new Slices("/x/", Array.from({ length: 40 }, () => 0)).until(39 * 5000);
    assert.equal(items.length, 40);
    assert.deepEqual(items.map(({ at }) => at), Array.from({ length: 40 }, (_, i) => i + 1), "in their order");
    assert.equal(most, 4);
  } finally {
    globalThis.fetch = before;
  }
});
