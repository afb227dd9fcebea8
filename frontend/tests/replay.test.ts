/** A recording's slices and story: what was known at a moment, back and forth. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { momentOf, Slices, unpackSlice } from "../src/replay/slices.ts";
import { type Index, Story } from "../src/replay/story.ts";
import { bytesOf, vectorsOf } from "./helpers.ts";

// of tests/vectors, as Python writes it: key 1, state 1, delta 2, picture 1, key 3, state 2, what nobody knows, picture 2
const { slices: SLICES } = vectorsOf<{ slices: string[] }>("recording_slices");
const DATA = bytesOf(SLICES[0]!).buffer;

/** A slice of one state, the first of the recording, at another time. */
function state(at: number): ArrayBuffer {
  const view = new DataView(DATA),
    begin = 8 + view.getUint32(0, true),
    part = DATA.slice(begin, begin + 8 + view.getUint32(begin, true));
  new DataView(part).setUint32(4, at, true);
  return part;
}

test("a slice is taken apart; what is not understood is left out, and a part that is cut off too", () => {
  const times = unpackSlice(DATA).map(({ at }) => at);
  assert.deepEqual(times, [0, 100, 200, 300, 900, 950, 990]);
  assert.equal(unpackSlice(DATA.slice(0, DATA.byteLength - 1)).length, 6);
  assert.deepEqual(unpackSlice(new ArrayBuffer(0)), []);
});

test("a moment is the newest of everything, and a stream since its key packet", () => {
  const items = unpackSlice(DATA);
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
    asked.push(address);
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

const NONE = { grant: 1, kind: "up", reason: "", at_ms: 0, result: {} };
const stage = (after_ms: number, id: number, state: string, more: object = {}): Index["commands"][number] => ({
  ...NONE,
  ...{ id, seq: id, state, after_ms, ...more },
});
const INDEX: Index = {
  began_ms: 1000,
  ended_ms: 9000,
  end: "",
  needs: [0, 0],
  cameras: [0],
  pictures: 2,
  commands: [
    stage(100, 1, "queued", { args: { x: 1 }, by: "ada" }),
    stage(300, 1, "completed"),
    stage(350, 1, "sent"),
    stage(500, 2, "queued"),
    stage(700, 2, "failed", { reason: "It slipped." }),
  ],
  events: [{ after_ms: 600, what: "gap", text: "A gap.", level: "warning" }],
};

test("what is known of commands at a moment; a late stage does not take an end back", () => {
  const story = new Story(INDEX, { index: "", slices: "", slug: "r", name: "R", who: "ada" });
  const known = (at: number): string => {
    const { commands } = story.snapshot(at, false);
    return commands.map(({ id, state }) => `${id} ${state}`).join(", ");
  };
  const wanted = ["", "1 queued", "1 completed", "2 queued, 1 completed", "2 failed, 1 completed"];
  assert.deepEqual([0, 200, 400, 600, 800].map(known), wanted);
  const { me, jobs, replay, operator } = story.snapshot(200, true);
  assert.deepEqual([replay, operator, jobs[0]?.args], [true, "ada", { x: 1 }]);
  assert.deepEqual(me.can, { watch: true, drive: false, ask: false, stop: false });
  const marks = story.marks().map(({ at, bad }) => `${at} ${bad}`);
  assert.deepEqual(marks, ["100 false", "500 false", "600 true", "700 true"]);
  const between = story.between(500, 700).commands.map(({ state }) => state);
  assert.deepEqual(between, ["failed"]);
});

test("of many slices that a moment needs, four are asked for at once", async () => {
  const before = globalThis.fetch,
    asked: string[] = [];
  let now = 0,
    most = 0;
  globalThis.fetch = (async (address: string) => {
    const number = asked.push(address);
    most = Math.max(most, ++now);
    await new Promise((done) => setTimeout(done, 1));
    now -= 1;
    return new Response(state(number));
  }) as typeof fetch;
  try {
    const slices = new Slices("/x/", new Array<number>(40).fill(0));
    const times = (await slices.until(39 * 5000)).map(({ at }) => at);
    const inOrder = Array.from({ length: 40 }, (_, i) => i + 1);
    assert.deepEqual(times, inOrder);
    assert.equal(most, 4);
  } finally {
    globalThis.fetch = before;
  }
});
