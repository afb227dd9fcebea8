/** One's own jobs: read until an answer has come, and never put back to what they were before a request. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { Jobs } from "../src/queue/jobs.ts";
import { settled, stub } from "./helpers.ts";

interface Asked {
  press: string | null;
  text: string | null;
  answer(body: object, ok?: boolean): void;
  fail(): void;
}
let asked: Asked[] = [];

function fetched(_address: string, init: RequestInit): Promise<Response> {
  return new Promise((resolve, reject) => {
    const sent = init.body instanceof URLSearchParams ? init.body : new URLSearchParams();
    asked.push({
      press: sent.get("press"),
      text: sent.get("arg-text"),
      answer: (body, ok = true) => resolve({ ok, json: () => Promise.resolve(body) } as Response),
      fail: () => reject(new TypeError("no connection")),
    });
  });
}
stub({ fetch: fetched });

const job = (id: number): object => ({ id, kind: "goal", args: {}, state: "waiting", open: true });

beforeEach(() => (asked = []));

test("what was not answered is asked for again at the next snapshot, and then no more", async () => {
  const jobs = new Jobs("irat", "", () => undefined);
  void jobs.refresh();
  asked[0]!.fail();
  await settled();
  jobs.update([]);
  assert.equal(asked.length, 2);
  asked[1]!.answer({ jobs: [] });
  await settled();
  jobs.update([]);
  assert.equal(asked.length, 2);
});

test("an answer that was read before a job was asked for does not make it vanish", async () => {
  const jobs = new Jobs("irat", "", () => undefined);
  void jobs.refresh();
  const made = jobs.ask("goal", {});
  asked[1]!.answer(job(7));
  assert.equal(await made, "");
  asked[0]!.answer({ jobs: [] });
  await settled();
  assert.equal(jobs.own.length, 1);
  asked[2]!.answer({ jobs: [job(7)] });
  await settled();
  assert.equal(jobs.own.length, 1);
});

test("a job that is asked for again before an answer came is the same press, and one after that is another", async () => {
  const jobs = new Jobs("irat", "", () => undefined);
  const presses = [jobs.ask("goal", { x: 1 }), jobs.ask("goal", { x: 1 })];
  assert.match(asked[0]!.press!, /^[\w-]{20,64}$/);
  assert.equal(asked[1]!.press, asked[0]!.press);
  void jobs.ask("goal", { x: 2 });
  assert.notEqual(asked[2]!.press, asked[0]!.press);
  for (const one of asked) one.answer(job(7));
  assert.deepEqual(await Promise.all(presses), ["", ""]);
  assert.equal(jobs.own.length, 1);
  void jobs.ask("goal", { x: 1 });
  assert.notEqual(asked[3]!.press, asked[0]!.press);
});

test("a request that may have arrived is sent again as the same press", async () => {
  const jobs = new Jobs("irat", "", () => undefined);
  const lost = jobs.ask("goal", {});
  asked[0]!.fail();
  assert.match(await lost, /has not confirmed/);
  void jobs.ask("goal", {});
  assert.equal(asked[1]!.press, asked[0]!.press);
});

test("a job carries the text of a program, and another text is another request", () => {
  const jobs = new Jobs("scout", "", () => undefined);
  void jobs.ask("mission", { text: "read" });
  void jobs.ask("mission", { text: "go South\nread" });
  void jobs.ask("goal", { x: 1 });
  const texts = asked.map(({ text }) => text);
  assert.deepEqual(texts, ["read", "go South\nread", null]);
  assert.notEqual(asked[0]!.press, asked[1]!.press);
});
