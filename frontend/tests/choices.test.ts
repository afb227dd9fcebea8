/** What a person reads of a choice that was not stored, or may have been. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { MailChoice } from "../src/queue/choices.ts";

const FAILURES: [error: Error, said: RegExp][] = [
  [new TypeError("Failed to fetch"), /could not be sent/],
  [new DOMException("", "TimeoutError"), /whether that was stored is not known/],
];

for (const [error, said] of FAILURES)
  test(`after a ${error.name} the choice stays as it was, and its text says what is known`, async (t) => {
    t.mock.method(globalThis, "fetch", async () => Promise.reject(error));
    const choice = new MailChoice("off", "token");
    assert.match(await choice.press(), said);
    assert.equal(choice.on, false);
  });
