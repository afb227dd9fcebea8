/** Messages for a person who looks elsewhere: what is said, with which urgency, and what sounds. */
import assert from "node:assert/strict";
import { beforeEach, mock, test } from "node:test";
import type { Announcer as Told } from "../src/queue/announcer.ts";
import type { QueuePlace } from "../src/queue/person_socket.ts";
import { queuePlace, stub } from "./helpers.ts";

const NOW = 1_000_000;
const storage = new Map<string, string>();
let started: number[] = []; // frequencies of the oscillators
let vibrated: number[][] = [];
let noted: string[] = [];

let state = "running";
let obeys = false; // the browser plays when it is asked to

class Sound {
  get state(): string {
    return state;
  }
  currentTime = 0;
  destination = {};
  resume = async (): Promise<void> => void (state = obeys ? "running" : state);
  createGain = (): object => ({
    gain: { setValueAtTime: () => undefined, exponentialRampToValueAtTime: () => undefined },
    connect: (to: object) => to,
  });
  createOscillator = (): object => {
    const frequency = { value: 0 };
    return { frequency, connect: (to: object) => to, start: () => started.push(frequency.value), stop: () => undefined };
  };
}

stub({
  document: { title: "Mercury", hidden: false, hasFocus: () => true, querySelector: () => null },
  addEventListener: () => undefined,
  navigator: { userActivation: { hasBeenActive: true }, vibrate: (times: number[]) => vibrated.push(times) },
  AudioContext: Sound,
  localStorage: { getItem: (key: string) => storage.get(key) ?? null, setItem: (key: string, value: string) => storage.set(key, value) },
});
const { Announcer } = await import("../src/queue/announcer.ts");

beforeEach(() => {
  storage.clear();
  started = [];
  vibrated = [];
  noted = [];
  [state, obeys] = ["running", false];
  mock.timers.reset();
  mock.timers.enable({ apis: ["setTimeout"] });
});

function page(): { teller: Told; polite: { textContent: string }; assertive: { textContent: string } } {
  const polite = { textContent: "" },
    assertive = { textContent: "" };
  const teller = new Announcer(polite as HTMLElement, assertive as HTMLElement, () => undefined, {
    show: ({ title, body }) => void noted.push(`${title}: ${body}`),
  });
  return { teller, polite, assertive };
}

const place = (state: QueuePlace["state"], seconds: number): QueuePlace => queuePlace({ state, ticket: 7, until_ms: NOW + seconds * 1000 });

test("of a turn's end 60 s are said politely, 20 and 10 s at once", () => {
  const { teller, polite, assertive } = page(),
    turn = place("operating", 61);
  const said = [61, 59, 58, 19, 9, 0].map((left) => {
    polite.textContent = assertive.textContent = "";
    teller.tell([turn], NOW + (61 - left) * 1000, "");
    return [polite.textContent, assertive.textContent];
  });
  assert.deepEqual(said, [
    ["", ""],
    ["60 seconds left in your turn on Mercury.", ""],
    ["", ""],
    ["", "20 seconds left in your turn on Mercury."],
    ["", "10 seconds left in your turn on Mercury."],
    ["", ""],
  ]);
  assert.deepEqual([started, vibrated], [[], []], "a turn's end makes no sound");
});

test("a new offer is said at once, sounds and vibrates, once", () => {
  const { teller, polite, assertive } = page(),
    offer = place("offered", 30);
  teller.tell([offer], NOW, "");
  assert.equal(assertive.textContent, "It is your turn on Mercury. You have 30 seconds to take control.");
  assert.equal(polite.textContent, "");
  assert.deepEqual(started, [660, 880]);
  assert.equal(vibrated.length, 1);
  assert.match(document.title, /^▶ Your turn!/);
  teller.tell([offer], NOW + 500, "");
  assert.equal(started.length, 2);
  assert.equal(vibrated.length, 1);
});

test("an offer that another page of this browser told is said, without sound", () => {
  const offer = place("offered", 30),
    other = page();
  page().teller.tell([offer], NOW, "");
  started = [];
  vibrated = [];
  other.teller.tell([offer], NOW + 100, "");
  assert.match(other.assertive.textContent, /^It is your turn on Mercury/);
  assert.deepEqual([started, vibrated], [[], []]);
  other.teller.tell([{ ...offer, until_ms: NOW + 90_000 }], NOW + 60_000, "");
  assert.equal(started.length, 2, "a later offer of the same place is a new one");
});

test("with the sound off nothing sounds; the phone still vibrates", () => {
  const { teller } = page();
  teller.sound = false;
  teller.tell([place("offered", 30)], NOW, "");
  assert.deepEqual(started, []);
  assert.equal(vibrated.length, 1);
});

test("before the page was touched nothing sounds or vibrates", () => {
  Object.assign(navigator.userActivation, { hasBeenActive: false });
  page().teller.tell([place("offered", 30)], NOW, "");
  Object.assign(navigator.userActivation, { hasBeenActive: true });
  assert.deepEqual([started, vibrated], [[], []]);
});

for (const paused of ["suspended", "interrupted"])
  test(`a chime that the browser does not play (${paused}) is not played later, and no other page is kept from it`, () => {
    state = paused;
    const { teller } = page();
    teller.tell([place("offered", 30)], NOW, "");
    assert.equal(teller.paused, true);
    mock.timers.tick(600);
    state = "running";
    assert.deepEqual([started, storage.get("farhand-told")], [[], undefined]);
    page().teller.tell([place("offered", 30)], NOW + 700, "");
    assert.deepEqual(started, [660, 880]);
  });

test("a chime that the browser plays at once when it is asked is heard", () => {
  [state, obeys] = ["suspended", true];
  const { teller } = page();
  teller.tell([place("offered", 30)], NOW, "");
  mock.timers.tick(600);
  assert.deepEqual(started, [660, 880]);
  assert.equal(teller.paused, false);
});

test("idleness is said at once, once, and again only after something was done", () => {
  const { teller, polite, assertive } = page();
  const idle = { ...place("operating", 200), idle_ms: NOW + 20_000, idles: true };
  const said = [
    [idle, 0],
    [idle, 5],
    [{ ...idle, idles: false }, 6],
    [{ ...idle, idle_ms: NOW + 126_000 }, 106],
  ] as const;
  const heard = said.map(([turn, after]) => {
    assertive.textContent = "";
    teller.tell([turn], NOW + after * 1000, "mercury");
    return assertive.textContent;
  });
  const words = "Your turn on Mercury ends in 20 seconds, because nothing was done. Press I'm here, or give a command.";
  assert.deepEqual(heard, [words, "", "", words]);
  assert.equal(polite.textContent, "");
  assert.match(document.title, /^! Your turn ends soon /);
});

test("the end of a turn is said once with its reason, and by a notification to who looks elsewhere", () => {
  Object.assign(document, { hidden: true });
  const over = { ...place("ended", 0), ended_ms: NOW, turn: 3, end: { why: "Staff ended it.", credited: "", next: "" } };
  const { teller, polite } = page();
  teller.tell([over], NOW, "");
  assert.equal(polite.textContent, "Your turn on Mercury is over. Staff ended it.");
  teller.tell([over], NOW + 500, "");
  page().teller.tell([over], NOW, ""); // another page of this browser
  assert.deepEqual(noted, ["Your turn on Mercury is over: Staff ended it."]);
  assert.match(document.title, /^! Turn over /);
  Object.assign(document, { hidden: false });
});

test("where the browser never plays, a second press of the sound's button switches it off", () => {
  state = "suspended";
  const { teller } = page();
  teller.tell([place("waiting", 0)], NOW, "");
  assert.equal(teller.ran, false, "nobody has heard anything that could be paused");
  const heard = [1, 2, 3].map(() => {
    teller.press();
    teller.tell([], NOW, "");
    return teller.sound;
  });
  assert.deepEqual(heard, [true, false, true]);
});

test("a press resumes a sound that was heard and is paused, each time", () => {
  obeys = true;
  const { teller } = page();
  for (let i = 0; i < 2; i++) {
    state = "suspended";
    teller.press();
    teller.tell([], NOW, "");
    assert.deepEqual([teller.sound, teller.paused, teller.ran], [true, false, true]);
  }
});
