/** The list of commands. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { latest } from "../src/words.ts";

const command = (state: string, id = 7): Parameters<typeof latest>[1] => ({ id, seq: 1, grant: 3, kind: "move", state, reason: "", at_ms: 0, result: {} });

test("a snapshot that was read before a command ended does not bring it back", () => {
  const cancelled = command("cancelled"), moving = command("acknowledged");
  assert.equal(latest(cancelled, moving), cancelled);
  assert.equal(latest(moving, cancelled), cancelled);
  assert.equal(latest(command("sent"), moving), moving);
  assert.equal(latest(undefined, moving), moving);
  assert.equal(latest(cancelled, command("unknown")).state, "unknown", "the server knows how it ended");
});

test("what the server has replaces what a page has refused by itself", () => {
  const read = command("acknowledged");
  assert.equal(latest(command("rejected", 0), read), read);
});
