/** What moves the ghost: gamepads, 6D mice and their reports, fingers, phones; how it is felt. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { wayOf } from "../src/input/feel.ts";
import { type Cap, capAfter, FILTER, REST } from "../src/input/hid.ts";
import { padReading } from "../src/input/pads.ts";
import { HandleSource } from "../src/input/pointer.ts";
import { type Hid, type HidDevice, SixAxis } from "../src/input/six_axis.ts";
import { isStill, type Move } from "../src/input/source.ts";
import { M_PER_S, RAD_PER_S } from "../src/input/speeds.ts";
import { handOf, orientation, turnSince } from "../src/input/touch.ts";
import { turnOf } from "../src/motion/linear.ts";
import { gamepad, seededDraw } from "./helpers.ts";

const report = (...numbers: number[]): DataView => {
  const data = new DataView(new ArrayBuffer(2 * numbers.length));
  numbers.forEach((v, i) => data.setInt16(2 * i, v, true));
  return data;
};
const bytes = (...values: number[]): DataView => new DataView(Uint8Array.from(values).buffer);
const rounded = (numbers: Iterable<number>): number[] => [...numbers].map((v) => Math.round(v * 1000) / 1000 || 0);

test("a cap that is pushed right, near and down, and turned", () => {
  const placed = capAfter(REST, 1, report(350, 0, 0));
  assert.deepEqual(rounded(placed.push), [0, -1, 0, 0, 0, 0], "to the right is against y");
  assert.deepEqual(rounded(capAfter(REST, 1, report(0, -350, -350)).push), [1, 0, 1, 0, 0, 0], "away from the person and up");
  const turned = capAfter(placed, 2, report(0, 0, -350));
  assert.deepEqual(rounded(turned.push), [0, -1, 0, 0, 0, 1], "to the left, from above");
  assert.deepEqual(rounded(capAfter(REST, 1, report(0, 0, 0, 0, 0, 350)).push), [0, 0, 0, 0, 0, -1], "newer devices send all six");
  assert.equal(capAfter(REST, 3, bytes(2, 0)).buttons, 2);
  assert.deepEqual(rounded(capAfter(REST, 1, report(20, -20, 10)).push), [0, 0, 0, 0, 0, 0], "a trembling cap is at rest");
});

test("reports of any kind and length, with any bytes, give shares from -1 to 1 or change nothing", () => {
  const draw = seededDraw(11);
  let cap: Cap = REST;
  for (let n = 0; n < 20_000; n++) {
    const length = Math.floor(draw(0, 80)),
      data = bytes(...Array.from({ length }, () => Math.floor(draw(0, 256)))),
      id = Math.floor(draw(0, 6)),
      before = cap;
    cap = capAfter(cap, id, data);
    assert.ok(cap.push.length === 6 && cap.push.every((v) => v >= -1 && v <= 1), `${id} ${length}`);
    const says = (id === 1 && (length === 6 || length >= 12)) || (id === 2 && length === 6) || (id === 3 && length >= 1);
    if (!says || length > 64) assert.equal(cap, before, `${id} ${length}`);
  }
});

/** A WebHID of one device, which a test plugs and unplugs. */
function hidOf(device: Partial<HidDevice> = {}): {
  hid: Hid;
  send: (id: number, data: DataView) => void;
  unplug: () => void;
  asked: object[];
} {
  const heard: ((event: never) => void)[] = [],
    gone: ((event: never) => void)[] = [],
    asked: object[] = [];
  const one = {
    productName: "A mouse",
    opened: false,
    open: () => Promise.resolve(),
    addEventListener: (_: string, act: (event: never) => void) => void heard.push(act),
    ...device,
  } as HidDevice;
  const hid: Hid = {
    requestDevice: (options) => {
      asked.push(options);
      return Promise.resolve([one]);
    },
    addEventListener: (_, act) => void gone.push(act),
  };
  const tell = (acts: typeof heard, event: object): void => acts.forEach((act) => act(event as never));
  return { hid, asked, send: (reportId, data) => tell(heard, { reportId, data, device: one }), unplug: () => tell(gone, { device: one }) };
}

test("a 6D mouse is asked for by a press, moves the ghost, and is gone when it is unplugged", async () => {
  const { hid, asked, send, unplug } = hidOf();
  let gone = 0;
  const six = new SixAxis(hid, () => true, () => void gone++); // prettier-ignore
  assert.equal(six.read(0.04), null);
  assert.equal(asked.length, 0, "nothing is asked by itself");
  assert.match(await six.connect(), /moves the ghost/);
  assert.deepEqual(asked, [{ filters: [FILTER] }]);
  send(3, bytes(1));
  assert.equal(six.read(0.04), null, "a button that is held since before it was seen at rest holds nothing");
  send(3, bytes(0));
  six.read(0.04);
  send(1, report(0, -350, 0));
  send(3, bytes(1));
  const reading = six.read(0.04)!;
  assert.ok(Math.abs(reading.by[0] - M_PER_S * 0.04) < 1e-9 && reading.clutch);
  for (let n = 0; n < 10; n++) six.read(0.04);
  assert.ok(isStill(six.read(0.04)!.by), "one that has fallen silent moves nothing");
  send(3, bytes(3));
  assert.equal(six.read(0.04)!.grip, "close");
  assert.equal(six.read(0.04)!.grip, "", "once a press");
  unplug();
  assert.equal(gone, 1);
  assert.equal(six.read(0.04), null);
});

test("without WebHID, without a choice, or with a device that does not open, it says so", async () => {
  const here = (): boolean => true,
    gone = (): void => undefined;
  assert.match(await new SixAxis(null, here, gone).connect(), /no WebHID/);
  const none: Hid = { requestDevice: () => Promise.resolve([]), addEventListener: () => undefined };
  assert.match(await new SixAxis(none, here, gone).connect(), /No 6D mouse was chosen/);
  const { hid } = hidOf({ open: () => Promise.reject(new Error("busy")) });
  assert.match(await new SixAxis(hid, here, gone).connect(), /could not be opened/);
});

test("a gamepad moves by its sticks, turns with its shoulder button, holds by its trigger, grips by its buttons", () => {
  const reading = (axes: number[], pressed: number[] = []): ReturnType<typeof padReading> => padReading(gamepad(axes, pressed), 0.5);
  assert.equal(reading([0, 0.2, 0, 0]), null);
  assert.deepEqual(rounded(reading([0, -1, 0, -1])!.by), rounded([M_PER_S / 2, 0, M_PER_S / 2, 0, 0, 0]));
  assert.deepEqual(rounded(reading([0, -1, -1, 0], [4])!.by), rounded([0, 0, 0, 0, RAD_PER_S / 2, RAD_PER_S / 2]));
  assert.deepEqual([reading([0, -1, 0, 0])!.clutch, reading([0, 0, 0, 0], [7])!.clutch], [false, true]);
  assert.deepEqual([reading([0, 0], [0])!.grip, reading([0, 0], [1])!.grip, reading([0, -1])!.grip], ["close", "open", ""]);
});

test("handles that are taken again begin where the ghost is, and let go once", () => {
  let letGo = 0;
  const handle = new HandleSource(() => void letGo++);
  assert.equal(handle.read(0.04), null);
  handle.take();
  handle.drag([0.3, 0, 0, 0, 0, 0]);
  assert.deepEqual(handle.read(0.04), { by: [0.3, 0, 0, 0, 0, 0], clutch: true, grip: "" });
  handle.release();
  assert.deepEqual([handle.read(0.04)!.clutch, handle.read(0.04)], [false, null]);
  handle.take();
  assert.ok(isStill(handle.read(0.04)!.by));
  handle.forget();
  handle.forget();
  assert.equal(letGo, 1);
  handle.drag([0.3, 0, 0, 0, 0, 0]);
  assert.equal(handle.read(0.04), null, "nobody holds it");
});

test("one finger moves along the table, two up, down and around", () => {
  assert.deepEqual(rounded(handOf([[0, 0]], [[0, -100]]).at), [0.05, 0, 0], "up on the pad is away from the base");
  assert.deepEqual(rounded(handOf([[0, 0]], [[-100, 0]]).at), [0, 0.05, 0]);
  const begin: [number, number][] = [[-50, 0], [50, 0]]; // prettier-ignore
  assert.deepEqual(rounded(handOf(begin, [[-50, -100], [50, -100]]).at), [0, 0, 0.05]); // prettier-ignore
  const { at, turn } = handOf(begin, [[0, 50], [0, -50]]); // prettier-ignore
  assert.deepEqual(rounded(at), [0, 0, 0]);
  assert.deepEqual(rounded(turnOf(turn)), rounded([0, 0, Math.PI / 2]), "to the left");
});

test("a phone's turns count from where the hand took it, whichever way it pointed", () => {
  for (const heading of [0, 77, 180, 359]) {
    const begin = orientation(heading, 0, 0)!;
    const turned = (alpha: number, beta: number, gamma: number): Move =>
      turnOf(turnSince(begin, orientation(alpha, beta, gamma)!)) as unknown as Move;
    assert.deepEqual(rounded(turned(heading, 0, 0)), [0, 0, 0]);
    assert.deepEqual(rounded(turned((heading + 30) % 360, 0, 0)), rounded([0, 0, Math.PI / 6]), "to the left, seen from above");
    assert.deepEqual(rounded(turned(heading, 30, 0)), rounded([0, -Math.PI / 6, 0]), "its upper edge goes up");
    assert.deepEqual(rounded(turned(heading, 0, 30)), rounded([Math.PI / 6, 0, 0]), "its right side goes down");
  }
  for (const bad of [null, NaN, Infinity]) assert.equal(orientation(0, bad, 0), null);
});

test("depth is felt by what moves the ghost, else heard, and never against the person's wish", () => {
  const all = { shakes: true, sounds: true, isCalm: false, hasPad: true, hasPhone: true };
  assert.equal(wayOf(all), "rumble");
  assert.equal(wayOf({ ...all, hasPad: false }), "vibration");
  assert.equal(wayOf({ ...all, hasPad: false, hasPhone: false }), "sound");
  assert.equal(wayOf({ ...all, isCalm: true }), "sound", "less motion was asked for");
  assert.equal(wayOf({ ...all, shakes: false }), "sound");
  assert.equal(wayOf({ ...all, shakes: false, sounds: false }), "");
});
