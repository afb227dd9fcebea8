/** The list of commands. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { laterStage } from "../src/socket/stages.ts";

/** As much of an element as the list writes. */
class Element {
  children: Element[] = [];
  dataset: Record<string, string> = {};
  classList = { toggle: () => undefined };
  textContent = "";
  hidden = false;
  append(...more: Element[]): void { this.children.push(...more); }
  insertBefore(child: Element, before: Element | null): void {
    this.children = this.children.filter((one) => one !== child);
    this.children.splice(before ? this.children.indexOf(before) : this.children.length, 0, child);
  }
  remove(): void {} // nothing leaves the list here
  setAttribute(): void {}
  removeAttribute(): void {}
}
Object.defineProperty(globalThis, "document", { value: { createElement: () => new Element() }, configurable: true });
const { CommandList } = await import("../src/page/command_list.ts");

function ladder(): { list: InstanceType<typeof CommandList>; rows: Element; said: Element } {
  const said = new Element(), rows = new Element();
  return { list: new CommandList(rows as never, said as never), rows, said };
}

const command = (state: string, id = 7): Parameters<typeof latest>[1] => ({ id, seq: 1, grant: 3, kind: "move", state, reason: "", at_ms: 0, result: {} });

test("a snapshot that was read before a command ended does not bring it back", () => {
  const cancelled = command("cancelled"), moving = command("acknowledged");
  assert.equal(laterStage(cancelled, moving), cancelled);
  assert.equal(laterStage(moving, cancelled), cancelled);
  assert.equal(laterStage(command("sent"), moving), moving);
  assert.equal(laterStage(undefined, moving), moving);
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
  assert.ok(list.busy(3, new Set()), "the socket into which it went is still there");
  list.lost(2, 2000);
  assert.ok(list.busy(3, new Set()), "the server may still be at it");
  list.lost(2, 5000);
  assert.ok(!list.busy(3, new Set()));
  assert.ok(list.ended(3, 1));
  list.update(command("acknowledged"));
  assert.ok(list.busy(3, new Set()), "it had arrived");
  list.lost(2, 60_000);
  assert.ok(list.busy(3, new Set()), "what the server has is not lost");
});

test("what the server never had stands where it was given, and not above everything later", () => {
  const { list, rows } = ladder();
  const states = (): (string | undefined)[] => rows.children.map((row) => row.dataset["state"]);
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
  assert.equal(rows.children[0]?.dataset["state"], "acknowledged");
  assert.equal(list.ended(3, 1), false);
  list.update({ ...command("sending", 0), seq: 2 });
  list.refuse(3, 2, "Too late.", 5);
  assert.equal(list.ended(3, 2), true, "its own command is refused");
});
