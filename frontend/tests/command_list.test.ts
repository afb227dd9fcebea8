/** The list of commands. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { browse } from "./browser.ts";
import type { CommandInfo } from "../src/socket/messages.ts";
import { laterStage } from "../src/socket/stages.ts";

const document = browse();
const { CommandList } = await import("../src/page/command_list.ts");

function ladder(): { list: InstanceType<typeof CommandList>; rows: HTMLElement; said: HTMLElement } {
  const said = document.createElement("p"),
    rows = document.createElement("ol");
  return { list: new CommandList(rows, said), rows, said };
}

const command = (state: string, id = 7): CommandInfo => ({ id, seq: 1, grant: 3, kind: "move", state, reason: "", at_ms: 0, result: {} });

test("a snapshot that was read before a command ended does not bring it back", () => {
  const cancelled = command("cancelled"),
    moving = command("acknowledged");
  assert.equal(laterStage(cancelled, moving), cancelled);
  assert.equal(laterStage(moving, cancelled), cancelled);
  assert.equal(laterStage(command("sent"), moving), moving);
  assert.equal(laterStage(undefined, moving), moving);
  const later = { ...moving, at_ms: 9 };
  assert.equal(laterStage(later, command("sent")), later, "the snapshot came slowly");
  assert.equal(laterStage(command("sent"), later), later);
  assert.equal(laterStage(cancelled, command("unknown")).state, "unknown", "the server knows how it ended");
});

test("what the server has replaces what a page has refused by itself", () => {
  const read = command("acknowledged");
  assert.equal(laterStage(command("rejected", 0), read), read);
});

test("an end that comes with a snapshot is told once, as one that comes by itself", () => {
  const { list, said } = ladder();
  const told: string[] = [];
  list.update(command("acknowledged"));
  list.whenEnded(3, 1, (c) => told.push(c.state));
  list.reset([command("completed")]);
  assert.match(said.textContent, /done/);
  said.textContent = "";
  list.update(command("completed"));
  assert.deepEqual([told, said.textContent], [["completed"], ""]);
  list.reset([command("failed", 8)].map((c) => ({ ...c, seq: 2 })));
  assert.equal(said.textContent, "", "what had ended before the page knew it is no news");
});

test("a command that went down with its socket ends, unless the server has it after all", () => {
  const { list } = ladder();
  const sent = { ...command("sending", 0), over: 1, at_ms: 1000 };
  list.update(sent);
  list.lost(1, 60_000);
  assert.ok(list.motion(3, new Set()), "the socket into which it went is still there");
  list.lost(2, 2000);
  assert.ok(list.motion(3, new Set()), "the server may still be at it");
  list.lost(2, 5000);
  assert.ok(!list.motion(3, new Set()));
  assert.ok(list.ended(3, 1));
  list.update(command("acknowledged"));
  assert.ok(list.motion(3, new Set()), "it had arrived");
  list.lost(2, 60_000);
  assert.ok(list.motion(3, new Set()), "what the server has is not lost");
});

test("what the server never had stands where it was given, and not above everything later", () => {
  const { list, rows } = ladder();
  const states = (): (string | undefined)[] => [...rows.querySelectorAll("li")].map((row) => row.dataset["state"]);
  list.update(command("completed", 7));
  for (const seq of [2, 3]) list.update({ ...command("sending", 0), seq });
  list.refuse(3, 2, "It is busy.", 0);
  assert.deepEqual(states(), ["sending", "rejected", "completed"]);
  list.update({ ...command("failed", 8), seq: 3 });
  list.update({ ...command("sent", 9), seq: 4 });
  assert.deepEqual(states(), ["sent", "failed", "rejected", "completed"]);
});

test("a refusal of this page's command leaves another page's command with the same number as it is", () => {
  const { list, rows } = ladder();
  list.update({ ...command("sending", 0), kind: "down" });
  list.update(command("acknowledged"));
  list.refuse(3, 1, "This was not carried out: another page of yours has given a command.", 5);
  assert.equal(rows.querySelector("li")?.dataset["state"], "acknowledged");
  assert.equal(list.ended(3, 1), false);
  list.update({ ...command("sending", 0), seq: 2 });
  list.refuse(3, 2, "Too late.", 5);
  assert.equal(list.ended(3, 2), true, "its own command is refused");
});

test("a row stays the same element from stage to stage, and says how far a long command is", () => {
  const { list, rows } = ladder();
  list.update({ ...command("sending", 0), kind: "scan" });
  const row = rows.querySelector("li");
  list.update({ ...command("acknowledged"), kind: "scan", progress: { text: "4 of 18", share: 0.25, at_ms: 5 } });
  list.update({ ...command("sending", 0), seq: 2 });
  assert.equal(rows.querySelectorAll("li")[1], row, "the newest stands above it");
  assert.equal(row?.className, "command acknowledged");
  assert.equal(row?.querySelectorAll(".steps .on").length, 3);
  assert.equal(row?.querySelector("progress")?.getAttribute("value"), "0.25");
  assert.equal(row?.querySelector(".progress span")?.textContent, "4 of 18");
  list.update({ ...command("acknowledged"), progress: { text: "somewhere", share: null, at_ms: 6 } });
  assert.equal(row?.querySelector("progress")?.hasAttribute("value"), false, "an unknown share");
  list.update({ ...command("failed"), reason: "It is too far." });
  assert.equal(row?.className, "command bad");
  assert.equal(row?.querySelector<HTMLElement>(".progress")?.hidden, true);
  assert.equal(row?.querySelector("p")?.textContent, "It is too far.");
});
