import assert from "node:assert/strict";
import { test } from "node:test";
import { frameOf, linkTo } from "../src/replay/share.ts";

test("a link names the second, and the beginning needs none", () => {
  assert.equal(linkTo("https://a.example/r/", 0), "https://a.example/r/");
  assert.equal(linkTo("https://a.example/r/", 75), "https://a.example/r/?t=75");
});

test("a title cannot end the attribute that it stands in", () => {
  const code = frameOf("https://a.example/", 'Turn of "x" <b> & y');
  assert.ok(code.includes('title="Turn of &quot;x&quot; &lt;b> &amp; y"'));
});
