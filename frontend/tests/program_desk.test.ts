/** What a desk of programs says of the one that was sent, and of saving. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { browse } from "./browser.ts";
import { settled, stub } from "./helpers.ts";
import type { RobotPage } from "../src/page/robot_page.ts";
import type { CommandInfo } from "../src/socket/messages.ts";

const document = browse(`
  <form id="program-form"></form><select id="program-list"></select><textarea id="program-text"></textarea><p id="program-said"></p>
  <p><input id="program-name"><input type="checkbox" id="program-shared"><button data-program="save"></button>
  <button data-program="delete" id="program-delete"></button></p>`);
stub({ Option: (document.defaultView as unknown as { Option: unknown }).Option });
const { ProgramDesk } = await import("../src/widgets/program_desk.ts");

const language = { parse: (text: string): string[] => text.split("\n"), print: (steps: readonly string[]): string => steps.join("\n") };
const use = { blocks: () => Promise.reject(new Error("none")), changed: () => undefined, refused: () => undefined };
const desk = new ProgramDesk<string>({ slug: "arm" } as RobotPage, language, "program", use);
const said = (): string => document.getElementById("program-said")!.textContent;
const row = (seq: number, state: string, more: Partial<CommandInfo> = {}): CommandInfo => ({
  ...{ id: seq, seq, grant: 3, kind: "program", state, reason: "", at_ms: 0, result: {} },
  ...more,
});

test("what becomes of a program is told as its row has it, and never before", () => {
  desk.follow(row(1, "completed"));
  assert.equal(said(), "", "it had ended before the page knew of it");
  for (const state of ["sending", "queued", "accepted", "sent"]) {
    desk.follow(row(2, state));
    assert.equal(said(), "It is sent and has not begun yet.");
  }
  desk.follow(row(2, "acknowledged"));
  assert.equal(said(), "It runs.");
  desk.follow(row(2, "acknowledged", { progress: { text: "step 2 of 9" } }));
  assert.equal(said(), "It runs: step 2 of 9.");
  desk.tell("Checked: 2 s, no forbidden box is touched.", "good");
  assert.equal(said(), "It runs: step 2 of 9.", "what runs is told instead");
  desk.follow(row(2, "cancelled", { reason: "The robot was stopped; it was held at step 2." }));
  assert.equal(said(), "Stopped. The robot was stopped; it was held at step 2.");
  assert.equal(document.getElementById("program-said")!.className, "program-said bad");
  desk.tell("Checked: 2 s, no forbidden box is touched.", "good");
  desk.follow(row(2, "cancelled", { reason: "The robot was stopped; it was held at step 2." }));
  assert.match(said(), /^Checked/, "its end is told once");
});

test("a refusal is told with its reason, and an end that is well", () => {
  desk.follow(row(3, "sending"));
  desk.follow(row(3, "rejected", { reason: "The robot is stopped." }));
  assert.equal(said(), "Refused. The robot is stopped.");
  desk.follow(row(4, "acknowledged"));
  desk.follow(row(4, "completed"));
  assert.equal(said(), "Done.");
});

test("saving is told in a line of its own from the press on, whatever a check says meanwhile", async () => {
  const saved = (): string => document.getElementById("program-saved")!.textContent;
  let answer: (ok: boolean) => void = () => undefined;
  const asked = (method = "GET"): Promise<unknown> =>
    method === "GET"
      ? Promise.resolve({ ok: true, json: () => Promise.resolve({ programs: [] }) })
      : new Promise((done) => (answer = (ok) => done({ ok, json: () => Promise.resolve(ok ? { id: 1, text: "" } : { error: "It needs a name." }) }))); // prettier-ignore
  stub({ fetch: (_: string, { method }: RequestInit = {}) => asked(method) });
  const press = async (ok: boolean): Promise<void> => {
    document.querySelector<HTMLElement>('[data-program="save"]')!.click();
    assert.equal(saved(), "Saving…");
    await settled();
    answer(ok);
    desk.tell("Checked: 2 s, no forbidden box is touched.", "good");
    await settled();
  };
  await press(false);
  assert.equal(saved(), "It needs a name.");
  await press(true);
  assert.equal(saved(), "Saved.");
  assert.match(said(), /^Checked/);
});
