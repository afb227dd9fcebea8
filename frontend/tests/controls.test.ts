import assert from "node:assert/strict";
import { test } from "node:test";
import { forward, nozzlePixel, onSand, reach, target } from "../../robots/kit/drivers/mercury/console/scara.ts";
import { type SandFacts as Facts, whyNot } from "../../robots/kit/drivers/mercury/console/rules.ts";
import { blocked } from "../src/page/controls.ts";
import { skipsForReducedMotion } from "../src/media/pictures.ts";
import { decode } from "../src/socket/decoder.ts";
import { ago, clock } from "../src/kit/times.ts";

const D = {
  arm: { link1: 0.4, link2: 0.25, q2_deg: [0, 160] as [number, number], up: 0.075, down: 0 },
  sand: { x: [-0.24, 0.24] as [number, number], y: [0.29, 0.55] as [number, number] },
  jog: { step: 0.008 },
};

test("reach and forward agree all over the sand", () => {
  for (let x = -0.24; x <= 0.24; x += 0.06)
    for (let y = 0.29; y <= 0.55; y += 0.04) {
      const arm = reach(D, x, y);
      assert.ok(arm);
      assert.ok(Math.hypot(arm.tool[0] - x, arm.tool[1] - y) < 1e-9);
      assert.ok(onSand(D, x, y));
    }
  assert.equal(reach(D, 2, 0), null);
  assert.equal(onSand(D, 0, 0.1), false);
});

test("the nozzle's pixel maps to no motion", () => {
  const u0 = [4.9e-4, 2e-5, 3e-3],
    v0 = [2e-5, -4.9e-4, -2e-3];
  const map = { matrix: [u0, v0], theta: 0 };
  const [u, v] = nozzlePixel(map, 192, 165);
  const [x, y] = target(map, [0.1, 0.4, 0, 0], u, v, 192, 165);
  assert.ok(Math.hypot(x - 0.1, y - 0.4) < 1e-12);
  assert.ok(forward(D, [0, 0]).tool[0] > 0.64);
});

const state = (z: number): Facts["state"] => {
  const rest = { moving: false, stopped: false, number: 1, atMs: 10_000, velocities: [], torques: [], values: [], mode: "" };
  return { ...rest, joints: [1, 1, z, 0] };
};

function facts(over: Partial<Facts> = {}, snapshot: object = {}): Facts {
  const f = {
    snapshot: {
      link: true,
      stopped: false,
      robot: { state: "operating", why: "", turns: true },
      me: { can: { drive: true } },
      ...snapshot,
    } as never,
    state: state(0),
    lineUp: true,
    now: 10_200,
    latency: 10,
    busy: false,
    ...over,
  };
  return { blocked: blocked(f), aim: "good", ...f };
}

test("a control is enabled, or it says why not", () => {
  assert.equal(blocked(facts()), "");
  assert.equal(whyNot("air", facts()), "");
  const no: [Facts, RegExp][] = [
    [facts({ lineUp: false }), /connection is lost/],
    [facts({}, { link: false }), /live link/],
    [facts({}, { stopped: true }), /release the stop/],
    [facts({}, { me: { can: { drive: false }, cleared: true } }), /Join the queue/],
    [facts({ now: 11_500 }), /state is not known/],
    [facts({ state: null }), /state is not known/],
    [facts({}, { robot: { state: "fault", why: "no power" } }), /no power/],
  ];
  for (const [f, why] of no) for (const kind of ["go", "up", "down", "air"]) assert.match(whyNot(kind, f), why);
  assert.match(whyNot("up", facts({ busy: true })), /One command at a time/);
  const up = facts({ state: state(0.075) });
  assert.match(whyNot("air", up), /Down first/);
  assert.match(whyNot("up", up), /up already/);
  assert.match(whyNot("down", facts()), /down already/);
  assert.match(whyNot("go", facts({ aim: "refused" })), /off the sand/);
  assert.match(whyNot("go", facts({ aim: "none" })), /choose where/);
});

test("a slow line is given more time, never more than three seconds", () => {
  assert.equal(blocked(facts({ latency: 800, now: 12_400 })), "");
  assert.notEqual(blocked(facts({ latency: 5000, now: 13_100 })), "");
});

test("binary packets decode, broken ones do not", () => {
  const view = new DataView(new ArrayBuffer(16 + 4 * 6 + 3));
  [1, 3].forEach((v, i) => view.setUint8(i, v));
  view.setBigInt64(6, 1234n, true);
  [2, 3].forEach((v, i) => view.setUint8(14 + i, v));
  [-1.5, 4.75, 0.5, 0, 100, -7].forEach((v, i) => view.setFloat32(16 + 4 * i, v, true));
  [..."RPY"].forEach((c, i) => view.setUint8(40 + i, c.charCodeAt(0)));
  const packet = decode(view.buffer);
  assert.ok(packet && "moving" in packet);
  assert.deepEqual([packet.moving, packet.stopped, packet.atMs, packet.mode], [true, true, 1234, "RPY"]);
  assert.deepEqual([...packet.joints, ...packet.velocities, ...packet.torques], [-1.5, 4.75, 0.5, 0, 100, -7]);
  assert.equal(packet.joints.length, 2);
  assert.equal(decode(view.buffer.slice(0, 30)), null, "cut off in the middle of the joints");
  assert.equal(decode(new ArrayBuffer(5)), null);
});

test("a picture says which camera took it", () => {
  const view = new DataView(new ArrayBuffer(19 + 4 + 2));
  [2, 1].forEach((v, i) => view.setUint8(i, v));
  view.setUint32(2, 7, true);
  view.setUint32(14, 55, true);
  view.setUint8(18, 1);
  view.setFloat32(19, 0.25, true);
  const packet = decode(view.buffer);
  assert.ok(packet && "jpeg" in packet);
  assert.deepEqual([packet.camera, packet.number, packet.still, packet.joints, packet.jpeg.size], [1, 7, 55, [0.25], 2]);
  assert.equal(decode(view.buffer.slice(0, 23)), null, "no picture in it");
});

test("times in words", () => {
  assert.equal(clock(61), "1:01");
  assert.equal(clock(-3), "0:00");
  assert.equal(ago(1500), "1.5 s");
});

test("a person who prefers reduced motion gets new stills, and one live picture in ten seconds", () => {
  const shown = { atMs: 50_000, stillId: 7 };
  assert.equal(skipsForReducedMotion({ atMs: 50_250, still: 7 }, shown), true, "the arm rests: the same picture again");
  assert.equal(skipsForReducedMotion({ atMs: 50_250, still: 0 }, shown), true, "it moves");
  assert.equal(skipsForReducedMotion({ atMs: 50_250, still: 8 }, shown), false, "a new still");
  assert.equal(skipsForReducedMotion({ atMs: 60_000, still: 0 }, shown), false, "ten seconds later");
});
