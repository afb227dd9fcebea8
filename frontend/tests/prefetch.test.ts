/** What is large is loaded beforehand, while the page has nothing else to do. */
import assert from "node:assert/strict";
import { mock, test } from "node:test";
import { prefetch } from "../src/kit/prefetch.ts";
import { settled } from "./helpers.ts";

test("large parts are loaded one after the other, while the page is idle; one that fails keeps none from coming", async () => {
  mock.timers.enable({ apis: ["setTimeout"] });
  const page = { idle: false },
    begun: string[] = [];
  let arrived: () => void = () => assert.fail("it was not begun");
  prefetch(page, () => (begun.push("view"), new Promise<void>((done) => (arrived = done))));
  prefetch(page, () => (begun.push("lost"), Promise.reject(new Error("the line is cut"))));
  prefetch(page, () => (begun.push("blocks"), Promise.resolve()));
  const after = async (ms: number): Promise<string> => {
    await settled();
    mock.timers.tick(ms);
    await settled();
    return begun.join(" ");
  };
  assert.equal(await after(60_000), "");
  page.idle = true;
  assert.equal(await after(2000), "view");
  assert.equal(await after(60_000), "view", "the next waits until it has come");
  arrived();
  assert.equal(await after(2000), "view lost");
  page.idle = false;
  assert.equal(await after(60_000), "view lost");
  page.idle = true;
  assert.equal(await after(2000), "view lost blocks");
});
