/** Requests have a limit, all of them. */
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { FILE_MS, request } from "../src/kit/request.ts";

const ROOT = new URL("../../", import.meta.url);

function sources(folder: string): string[] {
  return readdirSync(new URL(folder, ROOT), { recursive: true, encoding: "utf8" })
    .filter((name) => name.endsWith(".ts") && !name.includes("node_modules"))
    .map((name) => folder + name);
}

test("nothing in the pages asks the portal without a limit", () => {
  const names = [...sources("frontend/src/"), ...sources("robots/kit/drivers/")];
  assert.ok(names.includes("frontend/src/queue/person_socket.ts") && names.includes("robots/kit/drivers/pa10/console/programs.ts"));
  const asking = names.flatMap((name) => {
    const asked = readFileSync(new URL(name, ROOT), "utf8").match(/(?<![.\w])fetch\(|XMLHttpRequest|sendBeacon|AbortSignal\.timeout\(/g);
    return asked?.some((one) => !one.startsWith("Abort")) ? [[name, ...asked]] : [];
  });
  // the service worker is one file of its own
  const limited = [
    ["frontend/src/kit/request.ts", "fetch(", "AbortSignal.timeout("],
    ["frontend/src/push/worker.ts", "AbortSignal.timeout(", "fetch("],
  ];
  assert.deepEqual(asking, limited);
});

test("a request that lasts too long fails, also while its answer comes", async (t) => {
  const limits: number[] = [],
    limit = new AbortController();
  t.mock.method(AbortSignal, "timeout", (ms: number) => (limits.push(ms), limit.signal));
  const options: RequestInit[] = [];
  t.mock.method(globalThis, "fetch", (_: string, given: RequestInit) => {
    options.push(given);
    return new Promise((_, reject) => given.signal?.addEventListener("abort", () => reject(given.signal?.reason)));
  });
  const plain = request("/a", { method: "POST" }),
    file = request("/b", {}, FILE_MS);
  limit.abort(new DOMException("late", "TimeoutError"));
  await assert.rejects(plain, { name: "TimeoutError" });
  await assert.rejects(file, { name: "TimeoutError" });
  assert.deepEqual(limits, [10_000, FILE_MS]);
  assert.equal(options[0]?.method, "POST");
});
