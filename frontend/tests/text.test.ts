import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { gettext, ngettext, Sentences, translate } from "../src/kit/text.ts";

test("sentences are translated as the server translates them", () => {
  const vectors = JSON.parse(readFileSync(new URL("../../tests/vectors/sentences.json", import.meta.url), "utf8"));
  const sentences = new Sentences(vectors.catalogue, ",");
  for (const [text, expected] of vectors.texts) assert.equal(sentences.translate(text), expected);
});

test("without a catalogue texts are English, with their values", () => {
  assert.equal(gettext("{name} drives", { name: "Ada" }), "Ada drives");
  assert.equal(gettext("{name} drives {what}", { name: "{what}", what: "x" }), "{what} drives x");
  assert.equal(ngettext("{count} waits", "{count} wait", 1), "1 waits");
  assert.equal(ngettext("{count} waits", "{count} wait", 2), "2 wait");
  assert.equal(translate("The arm is off."), "The arm is off.");
});

test("beside the object of Django's own scripts in the admin, which has no catalogue, texts are English", async () => {
  Object.assign(globalThis, { django: { jQuery: {} } });
  const admin = await import(new URL("../src/kit/text.ts?admin", import.meta.url).href);
  assert.equal(admin.gettext("{name} drives", { name: "Ada" }), "Ada drives");
  assert.equal(admin.ngettext("{count} waits", "{count} wait", 2), "2 wait");
  assert.equal(admin.translate("The arm is off."), "The arm is off.");
});
