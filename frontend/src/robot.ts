/** A robot's page: everybody watches, the operator drives. */
import { nozzlePixel, onSand, target, type Description } from "./arm.ts";
import { CameraView } from "./camera.ts";
import { blocked, whyNot, type Facts } from "./controls.ts";
import { Ladder } from "./ladder.ts";
import { Live } from "./live.ts";
import { Place } from "./place.ts";
import type { Message, PicturePacket, Snapshot, StatePacket, Still } from "./protocol.ts";
import { Schematic } from "./schematic.ts";
import { byId } from "./svg.ts";
import { WireTrace } from "./trace.ts";
import { ago } from "./words.ts";

type Aim = { by: "camera"; u: number; v: number; still: number } | { by: "map"; x: number; y: number };

const page = byId("robot");
const description = JSON.parse(byId("description").textContent ?? "{}") as Description;
let snapshot: Snapshot | null = null;
let state: StatePacket | null = null;
let aim: Aim | null = null;
let seq = 0;
let seqGrant = 0;
let lineDownAt = performance.now();
let airStill = 0;
let sentAim: Aim | null = null;

const say = byId("say");
const ladder = new Ladder(byId("ladder"), say);
const camera = new CameraView(byId("screen"), byId<HTMLCanvasElement>("picture"), byId<SVGSVGElement>("overlay"), pickPixel);
const schematic = new Schematic(byId<SVGSVGElement>("schematic"), description, pickPoint);
const live = new Live(
  page.dataset["slug"] ?? "",
  { message, state: gotState, picture: gotPicture, line: gotLine },
  () => (snapshot?.me.operating ? 2000 : 10_000),
);
const place = new Place(byId("place"), say, (m) => live.send(m));
const trace = document.getElementById("trace") ? new WireTrace(byId("trace"), byId("trace-rate")) : null;

function gotLine(up: boolean): void {
  if (!up) lineDownAt = performance.now();
  draw();
}

const calm = matchMedia("(prefers-reduced-motion: reduce)");

/** With reduced motion, who only watches gets stills and one live picture in ten seconds. */
function gotPicture(packet: PicturePacket): void {
  const still = packet.still !== 0 && packet.still !== camera.still;
  if (calm.matches && !snapshot?.me.operating && !still && packet.atMs - camera.atMs < 10_000) return;
  void camera.show(packet).then(draw);
}

function gotState(packet: StatePacket): void {
  state = packet;
  schematic.joints(packet.joints);
}

function message(m: Message): void {
  if (m.t === "snapshot") gotSnapshot(m);
  else if (m.t === "command") gotCommand(m);
  else if (m.t === "answer") gotAnswer(m);
  else if (m.t === "notice") notice(m.text, m.level);
  else if (m.t === "trace") trace?.add(m);
  else if (m.t === "pong" && snapshot) snapshot.link = m.link;
  draw();
}

function gotSnapshot(s: Snapshot): void {
  const wasOperating = snapshot?.me.operating ?? false;
  const hadStill = snapshot?.still?.id;
  snapshot = s;
  if (s.turn && s.turn.grant !== seqGrant) {
    seqGrant = s.turn.grant;
    seq = s.turn.next_seq - 1;
    aim = null;
  } else if (s.turn) seq = Math.max(seq, s.turn.next_seq - 1);
  ladder.reset(s.commands);
  place.announce(s);
  if (s.still && s.still.id !== hadStill) gotStill(s.still);
  if (trace && s.me.staff) live.send({ t: "trace", on: true });
  if (wasOperating && !s.me.operating && s.me.last_turn) notice("Your turn is over. Thank you! Write down what you found.", "info");
  if (!wasOperating && s.me.operating) byId("screen").focus({ preventScroll: true });
  drawLog(s);
}

function gotStill(still: Still): void {
  schematic.covers(still, mapFor(still));
  schematic.joints(state?.joints ?? still.joints);
  if (camera.atMs >= still.at_ms) return;
  const image = new Image();
  image.onload = () => {
    if (camera.atMs < still.at_ms) camera.draw(image, still.at_ms, still.id);
    draw();
  };
  image.src = still.url;
}

function gotCommand(m: { t: "command" } & Snapshot["commands"][number]): void {
  ladder.update(m);
  if (m.state === "completed" && m.kind === "air" && snapshot?.still) airStill = snapshot.still.id;
  if (m.state === "completed" && aim === sentAim) aim = null;
}

function gotAnswer(m: Extract<Message, { t: "answer" }>): void {
  if (!m.ok && m.to === "command") {
    ladder.update({ id: 0, seq: m.seq ?? 0, grant: seqGrant, kind: "move", state: "rejected", reason: m.text, at_ms: live.now(), result: {} });
    notice(m.text, "warning");
  } else if (m.text) notice(m.text, m.ok ? "info" : "warning");
}

let noticeTimer = 0;
function notice(text: string, level: string): void {
  const box = byId("notice");
  box.textContent = text;
  box.className = `notice ${level}`;
  box.hidden = false;
  clearTimeout(noticeTimer);
  noticeTimer = window.setTimeout(() => (box.hidden = true), level === "info" ? 6000 : 12_000);
}

function mapFor(still: Still): { matrix: number[][]; theta: number } | null {
  const z = still.pose[2] ?? 0;
  return Object.values(still.calibration).find((e) => Math.abs(e.z - z) < 0.005) ?? null;
}

function pickPixel(u: number, v: number): void {
  if (!snapshot?.me.operating || !snapshot.still) return;
  aim = { by: "camera", u, v, still: camera.still || snapshot.still.id };
  draw();
}

function pickPoint(x: number, y: number): void {
  if (!snapshot?.me.operating) return;
  aim = { by: "map", x, y };
  draw();
}

function aimPoint(): [number, number] | null {
  if (!aim) return null;
  if (aim.by === "map") return [aim.x, aim.y];
  const still = snapshot?.still;
  const map = still ? mapFor(still) : null;
  return still && map ? target(map, still.pose, aim.u, aim.v, still.width, still.height) : null;
}

function aimState(): Facts["aim"] {
  if (!aim) return "none";
  if (aim.by === "camera" && aim.still !== snapshot?.still?.id) return "old";
  const at = aimPoint();
  return at && onSand(description, ...at) ? "good" : "refused";
}

function facts(): Facts {
  return {
    snapshot, state, lineUp: live.up, now: live.now(), latency: live.latency, aim: aimState(),
    busy: seqGrant !== 0 && ladder.busy(seqGrant),
  };
}

function command(kind: string, args: object = {}): void {
  const why = whyNot(kind === "click" || kind === "move" ? "go" : kind, facts());
  if (why) return notice(why, "warning");
  seq += 1;
  ladder.update({ id: 0, seq, grant: seqGrant, kind, state: "sending", reason: "", at_ms: live.now(), result: {} });
  performance.mark(`command-${seq}`);
  live.send({ t: "command", kind, args, seq });
  draw();
}

function go(): void {
  if (!aim) return notice(whyNot("go", facts()), "warning");
  sentAim = aim;
  if (aim.by === "camera") command("click", { still: aim.still, u: aim.u, v: aim.v });
  else command("move", { x: aim.x, y: aim.y });
}

const BUTTONS: Record<string, () => void> = {
  go, up: () => command("up"), down: () => command("down"), air: () => command("air"),
  stop: () => { if (!live.send({ t: "stop" })) notice("The connection is gone: the robot stops by itself when it notices.", "error"); },
  release: () => live.send({ t: "release", checked: byId<HTMLInputElement>("checked").checked }),
};
for (const [name, run] of Object.entries(BUTTONS))
  document.querySelector(`[data-command="${name}"]`)?.addEventListener("click", (event) => {
    const button = event.currentTarget as HTMLElement;
    if (button.getAttribute("aria-disabled") === "true") return notice(button.dataset["why"] ?? "", "warning");
    run();
  });

byId("console").addEventListener("keydown", (event) => {
  const field = (event.target as HTMLElement).closest("input, textarea, button, a");
  if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
  const keys: Record<string, string> = { u: "up", d: "down", a: "air", Enter: "go", s: "stop", Escape: "stop" };
  const name = keys[event.key];
  if (event.key === "?") return void byId<HTMLDialogElement>("keys").showModal();
  if (!name || (field && name !== "stop") || (name !== "stop" && !snapshot?.me.operating)) return;
  if (name === "stop" && !snapshot?.me.may_stop) return;
  event.preventDefault();
  BUTTONS[name]?.();
});
byId("keys-open").addEventListener("click", () => byId<HTMLDialogElement>("keys").showModal());

function text(id: string, value: string): void {
  const element = byId(id);
  if (element.textContent !== value) element.textContent = value;
}

function draw(): void {
  const f = facts();
  drawBanner(f);
  drawAge(f);
  if (!snapshot) return;
  page.dataset["state"] = snapshot.robot.state;
  page.classList.toggle("operating", snapshot.me.operating);
  text("state", snapshot.robot.label);
  text("why-state", snapshot.robot.why);
  text("operator", snapshot.operator ? `${snapshot.operator} drives` : "Nobody drives");
  text("queue", snapshot.queue === 0 ? "nobody waits" : `${snapshot.queue} waiting`);
  place.draw(snapshot, live.now(), live.up);
  drawControls(f);
  drawAim(f);
  drawBefore();
}

function drawBanner(f: Facts): void {
  const banner = byId("banner");
  const down = !f.lineUp && performance.now() - lineDownAt > 1000;
  const words = down ? "Connection lost. Trying again…" : snapshot && !snapshot.link ? "The live link to the robots is down. Pages work; nothing moves until it is back." : "";
  if (banner.textContent !== words) banner.textContent = words;
  banner.hidden = !words;
}

function drawAge(f: Facts): void {
  const age = camera.atMs ? f.now - camera.atMs : Infinity;
  const badge = byId("age");
  badge.textContent = camera.atMs ? `Picture ${ago(age)} old` : "No picture yet";
  badge.dataset["age"] = age < 2000 ? "fresh" : age < 5000 ? "ageing" : "old";
  text("latency", live.latency === null ? "" : `${Math.round(live.latency)} ms`);
  const z = state?.joints[2];
  text("height", z === undefined ? "" : z < 0.001 ? "Down, Z = 0" : `Z = ${Math.round(z * 1000)} mm`);
}

function drawControls(f: Facts): void {
  byId("controls").hidden = !snapshot?.me.operating && !snapshot?.me.may_stop;
  for (const name of ["go", "up", "down", "air"]) {
    const button = document.querySelector<HTMLElement>(`[data-command="${name}"]`);
    const why = whyNot(name, f);
    button?.setAttribute("aria-disabled", String(why !== ""));
    if (button) button.dataset["why"] = why;
  }
  const stopped = snapshot?.stopped || f.state?.stopped || false;
  byId("release").hidden = !stopped || !snapshot?.me.may_stop;
  const line = blocked(f) || (f.busy ? "The arm is busy." : whyNot("go", f) || "Enter or “Move here” sends the arm.");
  text("why", line);
}

function drawAim(f: Facts): void {
  const still = snapshot?.still ?? null;
  const map = still ? mapFor(still) : null;
  const at = aimPoint();
  schematic.aim(snapshot?.me.operating ? at : null);
  const from = still && map && snapshot?.me.operating ? nozzlePixel(map, still.width, still.height) : null;
  camera.aim(aim?.by === "camera" && f.aim !== "old" ? [aim.u, aim.v] : null, from);
  byId("screen").classList.toggle("refused", f.aim === "refused");
}

function drawBefore(): void {
  const box = byId("before");
  const { before, still } = snapshot ?? {};
  const after = snapshot?.commands.find((c) => c.result?.still === still?.id);
  const show = Boolean(before && still && after?.kind === "air");
  box.hidden = !show;
  if (!show || !before || !still || airStill === -still.id) return;
  byId<HTMLImageElement>("before-picture").src = before.url;
  byId<HTMLImageElement>("after-picture").src = still.url;
  airStill = -still.id;
}

function drawLog(s: Snapshot): void {
  byId("log").replaceChildren(
    ...s.log.map((e) => {
      const item = document.createElement("li");
      const head = document.createElement("b");
      head.textContent = e.author;
      const when = document.createElement("time");
      when.textContent = ` ${ago(live.now() - e.at_ms)} ago`;
      const words = document.createElement("p");
      words.textContent = e.text;
      item.append(head, when, words);
      if (e.picture) {
        const image = new Image(96, 82);
        image.src = e.picture;
        image.alt = `Picture chosen by ${e.author}`;
        item.prepend(image);
      }
      return item;
    }),
  );
}

setInterval(draw, 250);
