/** What is drawn again stays the same elements: with the focus, a press and the place to which somebody has scrolled. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { browse } from "./browser.ts";

const document = browse();
const { html } = await import("lit-html");
const { allowed, button, countdown, draw, drawParts, fill, heading, link, paragraph, words } = await import("../src/kit/render.ts");
const { allow, refusal } = await import("../src/kit/refusal.ts");

function box(content = ""): HTMLElement {
  const made = document.createElement("div");
  made.innerHTML = content;
  document.body.append(made);
  return made;
}

/** What changes in a box during `act`. */
function changes(of: HTMLElement, act: () => void): MutationRecord[] {
  const observer = new MutationObserver(() => undefined);
  observer.observe(of, { subtree: true, childList: true, characterData: true, attributes: true });
  act();
  const found = observer.takeRecords();
  observer.disconnect();
  return found;
}

test("what the server put there goes at the first drawing", () => {
  const place = box("<p>as old as the page</p>");
  drawParts(place, [heading("You drive")]);
  assert.equal(place.textContent, "You drive");
  assert.equal(place.children.length, 1);
});

test("what is drawn again without a change touches nothing, so that nothing is read out twice", () => {
  const place = box(),
    parts = (): Parameters<typeof drawParts>[1] => [
      heading("You drive"),
      countdown("1:20"),
      paragraph("left in your turn"),
      button("End my turn", "leave"),
      link("All jobs", "/jobs/"),
    ];
  drawParts(place, parts());
  const found = changes(place, () => drawParts(place, parts()));
  assert.deepEqual(found, []);
});

test("a countdown changes its text alone", () => {
  const place = box(),
    parts = (left: string): Parameters<typeof drawParts>[1] => [heading("You drive"), countdown(left), button("End my turn", "leave")];
  drawParts(place, parts("1:20"));
  const found = changes(place, () => drawParts(place, parts("1:19")));
  assert.equal(found.map(({ type }) => type).join(), "characterData");
  assert.equal(place.querySelector("[role=timer]")?.textContent, "1:19");
});

test("a button that has the focus or is held stays, whatever comes and goes around it", () => {
  const place = box(),
    end = (text: string): ReturnType<typeof button> => button(text, "leave");
  drawParts(place, [heading("You drive"), countdown("0:20"), end("End my turn")]);
  const held = place.querySelector("button")!;
  held.focus();
  const parts = [heading("You drive"), paragraph("new"), countdown("0:19"), end("Press again"), paragraph("more")];
  const moved = changes(place, () => drawParts(place, parts));
  assert.equal(place.querySelector("button"), held);
  assert.equal(document.activeElement, held);
  assert.equal(held.textContent, "Press again");
  const touched = moved.flatMap(({ removedNodes, addedNodes }) => [...removedNodes, ...addedNodes]);
  assert.ok(!touched.includes(held), "it was not taken out for a moment");
});

test("a part of another kind, action or address is another element, so that no press counts for what it was not meant for", () => {
  const place = box();
  drawParts(place, [button("Take control", "accept", { style: "primary" }), button("Not now", "leave", { style: "later" })]);
  const [accept, leave] = place.children;
  drawParts(place, [button("Join the queue", "join", { style: "primary" }), button("Not now", "leave", { style: "later" })]);
  assert.equal(accept?.isConnected, false);
  assert.equal(place.children[1], leave);
  drawParts(place, [link("Back", "/robots/mercury/")]);
  const back = place.children[0];
  drawParts(place, [link("Back", "/robots/pa10/")]);
  assert.notEqual(place.children[0], back);
});

test("parts of the same kind keep their order", () => {
  const place = box();
  drawParts(place, [words("one"), words("two")]);
  const [one, two] = place.children;
  drawParts(place, [words("one"), words("two"), words("three")]);
  assert.deepEqual([...place.children].slice(0, 2), [one, two]);
  assert.equal(place.textContent, "onetwothree");
});

test("a disabled button says why, keeps its place, and works again", () => {
  const place = box();
  drawParts(place, [button("Cancel", "cancel", { why: "Your last press is on its way.", pressed: false })]);
  const made = place.querySelector("button")!;
  assert.equal(refusal(made), "Your last press is on its way.");
  assert.equal(made.getAttribute("aria-pressed"), "false");
  assert.equal(made.disabled, false, "it keeps the focus");
  drawParts(place, [button("Cancel", "cancel", { pressed: true })]);
  assert.equal(place.querySelector("button"), made);
  assert.equal(refusal(made), "");
  allow(made, "no");
  draw(place.appendChild(document.createElement("p")), html`<a ${allowed("why")}>x</a>`);
  assert.equal(refusal(place.querySelector("a")!), "why");
});

test("rows of words change cell by cell, so that a scrolled table stays where it is", () => {
  const place = box("<table><tbody><tr><td>old</td></tr></tbody></table>"),
    body = place.querySelector("tbody")!;
  const show = (first: string, second: string): void =>
    fill(
      body,
      [`q1 ${first} m`, `q2 ${second} m`].map((row) => row.split(" ")),
    );
  show("0.10", "0.20");
  const cells = [...body.querySelectorAll("th, td")].map((cell) => `${cell.tagName} ${cell.textContent}`);
  assert.deepEqual(cells, ["TH q1", "TD 0.10", "TD m", "TH q2", "TD 0.20", "TD m"]);
  assert.equal(body.rows.length, 2);
  assert.equal(body.rows[0]?.cells[0]?.scope, "row");
  const found = changes(place, () => show("0.10", "0.21"));
  assert.equal(found.length, 1);
  fill(body, [["q1", "0.10"]]);
  assert.equal(body.rows.length, 1);
  assert.equal(body.rows[0]?.cells.length, 2);
});
