import assert from "node:assert/strict";
import { test } from "node:test";
import { align, isToken, morph } from "../src/kit/morph.ts";
import { nextPause } from "../src/page/pending_parts.ts";
import { browse } from "./browser.ts";

const kinds = { alike: (a: string, b: string) => a[0] === b[0], weight: (one: string) => (one.includes("!") ? 100 : 1) };
const stays = (old: string[], fresh: string[]): string[] => [...align(old, fresh, kinds)].map(([now, was]) => `${was}>${now}`);

test("what comes between stays apart from what is there", () => {
  assert.deepEqual(
    stays(["h1", "p1", "f1", "u1", "p2"], ["h2", "p3", "p4", "f2", "u2", "p5"]).filter((one) => /^[hfu]/.test(one)),
    ["h1>h2", "f1>f2", "u1>u2"],
  );
  assert.deepEqual(stays(["p1", "f1"], ["f2", "p2"]).length, 1);
  assert.deepEqual(stays([], ["f"]), []);
});

test("what is pressed stays, whatever else has to go for it", () => {
  assert.deepEqual(stays(["p1", "p2", "p3", "f1!"], ["f2", "p4", "p5", "p6"]), ["f1!>f2"]);
});

test("tokens of forms are no news, what somebody chose is", () => {
  for (const name of ["csrfmiddlewaretoken", "once", "press"]) assert.ok(isToken("hidden", name));
  assert.ok(!isToken("hidden", "kind"));
  assert.ok(!isToken("text", "once"));
});

test("an element becomes like another one; what is alike stays, and news is what the page's observer sees", () => {
  const document = browse();
  const made = (html: string): Element => {
    const box = document.createElement("div");
    box.innerHTML = html;
    return box.firstElementChild!;
  };
  const token = (value: string): string => `<input type="hidden" name="once" value="${value}">`;
  const old = made(`<section id="part" data-arrives><p>It is made.</p><form>${token("1")}<button>Cancel</button></form></section>`);
  const button = old.querySelector("button"),
    observer = new MutationObserver(() => undefined);
  observer.observe(old, { attributes: true, characterData: true, childList: true, subtree: true });
  morph(old, made(old.outerHTML.replace('value="1"', 'value="2"')));
  assert.equal(observer.takeRecords().length, 0, "another token is no news");
  morph(
    old,
    made(
      `<section id="part" class="done"><p>It is there.</p><a href="/x">Open</a><form>${token("3")}<button>Cancel</button></form></section>`,
    ),
  );
  assert.ok(observer.takeRecords().length > 0);
  const wanted = `<section id="part" class="done"><p>It is there.</p><a href="/x">Open</a><form>${token("1")}<button>Cancel</button></form></section>`;
  assert.equal(old.outerHTML, wanted);
  assert.equal(old.querySelector("button"), button);
});

test("without news the pause grows to ten seconds", () => {
  let pause = nextPause(5000, true);
  assert.equal(pause, 1000);
  for (let n = 0; n < 9; n++) pause = nextPause(pause, false);
  assert.equal(pause, 10_000);
});
