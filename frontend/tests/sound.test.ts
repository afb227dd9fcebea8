/** The robot's sound while the browser pauses it: a telephone call, a page that nobody sees. */
import assert from "node:assert/strict";
import { beforeEach, mock, test } from "node:test";
import type { Sound as Heard } from "../src/media/sound.ts";
import { stub } from "./helpers.ts";

let now = 0;
let contexts: Context[] = [];
let obeys = true; // the browser plays when it is asked to
let listeners: Record<string, ((event: { target: object }) => void)[]> = {};
let asked: boolean[] = [];

class Context {
  state = "running";
  currentTime = 0;
  destination = {};
  closed = false;
  changed: () => void = () => undefined;
  constructor() {
    contexts.push(this);
  }
  addEventListener = (_: string, changed: () => void): void => void (this.changed = changed);
  createAnalyser = (): object => ({ fftSize: 0, connect: () => undefined, getFloatTimeDomainData: () => undefined });
  close = async (): Promise<void> => void (this.closed = true);
  resume = async (): Promise<void> => {
    if (!obeys) throw new Error("not now");
    this.become("running");
  };
  become(state: string): void {
    this.state = state;
    this.changed();
  }
}

class Element {
  textContent = "";
  hidden = false;
  value = 0;
  attributes: Record<string, string> = {};
  dataset = {};
  click = (): void => undefined;
  addEventListener = (_: string, press: () => void): void => void (this.click = press);
  setAttribute = (name: string, value: string): void => void (this.attributes[name] = value);
  getAttribute = (name: string): string | null => this.attributes[name] ?? null;
  contains = (other: unknown): boolean => other === this;
}

const on = (name: string, heard: (event: { target: object }) => void): void => void (listeners[name] ??= []).push(heard);
stub({
  document: { hidden: false, addEventListener: on },
  addEventListener: on,
  window: globalThis,
  Node: Element,
  performance: { now: () => now },
  AudioContext: Context,
  AudioDecoder: class {
    static isConfigSupported = async (): Promise<object> => ({ supported: true });
    state = "configured";
    configure = (): void => undefined;
    close = (): void => undefined;
  },
});
const { Sound } = await import("../src/media/sound.ts");
const PAUSED = "Sound paused. Press to hear again.";

function listening(): { sound: Heard; button: Element; words: Element } {
  const button = new Element(),
    words = new Element();
  const sound = new Sound(button as never, words as never, new Element() as never, (wanted) => asked.push(wanted));
  button.click();
  return { sound, button, words };
}

function happens(name: string, target: object = {}): void {
  for (const heard of listeners[name] ?? []) heard({ target });
}

function seen(yes: boolean): void {
  Object.assign(document, { hidden: !yes });
  happens("visibilitychange");
}

beforeEach(() => {
  mock.timers.reset();
  mock.timers.enable({ apis: ["setTimeout"] });
  [now, contexts, obeys, listeners, asked] = [10_000, [], true, {}, []];
  Object.assign(document, { hidden: false });
});

for (const state of ["interrupted", "suspended"])
  test(`a sound that is ${state} and does not come back is said, and a press begins it anew`, async () => {
    const { sound, button, words } = listening();
    assert.equal(button.attributes["aria-pressed"], "true");
    obeys = false;
    contexts[0]!.become(state);
    now += 1500;
    sound.draw("");
    assert.equal(words.textContent, PAUSED);
    assert.equal(button.attributes["aria-pressed"], "false");
    now += 60_000; // nothing comes either
    sound.draw("");
    assert.equal(words.textContent, PAUSED);
    happens("pointerdown", button); // the press must not be taken for one that ends the sound
    button.click();
    assert.deepEqual([contexts.length, contexts[0]!.closed], [2, true]);
    assert.equal(button.attributes["aria-pressed"], "true");
    assert.equal(words.textContent, "");
    assert.equal(asked.at(-1), true);
  });

for (const name of ["pageshow", "focus", "pointerup", "keydown"])
  test(`a paused sound comes back at ${name} wherever that is`, () => {
    const { sound, words } = listening();
    obeys = false;
    contexts[0]!.become("interrupted");
    now += 1500;
    obeys = true;
    happens(name);
    sound.draw("");
    assert.deepEqual([contexts[0]!.state, words.textContent], ["running", ""]);
  });

test("a page that nobody has seen for a while has no sound sent, and has it again when somebody sees it", () => {
  const { sound, button } = listening();
  seen(false);
  mock.timers.tick(5001);
  assert.equal(asked.at(-1), false);
  assert.equal(contexts[0]!.closed, true);
  seen(true);
  assert.equal(asked.at(-1), true);
  assert.equal(contexts.length, 2);
  sound.draw("");
  assert.equal(button.attributes["aria-pressed"], "true");
});

test("who has ended the sound hears nothing after they come back", () => {
  const { button } = listening();
  button.click();
  seen(false);
  mock.timers.tick(5001);
  seen(true);
  assert.deepEqual([asked.at(-1), contexts.length], [false, 1]);
});
