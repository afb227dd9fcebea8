/** The page of a recording: the bar to move in time, and the list of moments to jump to. */
import "./replay.css";
import { byId, make, say, set, shape } from "../kit/dom.ts";
import { FILE_MS, request } from "../kit/request.ts";
import { clock } from "../kit/times.ts";
import { gettext, translate } from "../kit/text.ts";
import { useRecording } from "../socket/connection.ts";
import type { Handlers } from "../socket/robot_socket.ts";
import { Player } from "./player.ts";
import { share } from "./share.ts";
import { type About, type Index, type Mark, Story } from "./story.ts";

const FAILED = gettext("The recording could not be read. Check your connection, and choose a time again.");
const UNREAD = gettext("The recording could not be read. This page tries again every few seconds.");
const GONE = gettext("The file of this recording is gone, so it cannot be replayed.");
const LOADING = gettext("Loading…"),
  LONG_MS = 500,
  AGAIN_MS = 3000;
const WIDE = 1000; // of the drawing of marks
const STEP_MS = 500;

/** What a page reads of its connection while it shows a recording. */
const CONNECTED = { up: true, lost: false, lostMs: 0, opened: 1, latency: null, best: Infinity, overdue: false };

const about = JSON.parse(byId("replay-facts").textContent) as About;
const button = byId<HTMLButtonElement>("replay-play"),
  range = byId<HTMLInputElement>("replay-at");
const speed = byId<HTMLSelectElement>("replay-speed"),
  said = byId("replay-said"),
  time = byId("replay-time");
let player: Player | null = null;
let moved = 0,
  loading = 0,
  held = false;

function tellValue(words: string): void {
  set(range, { "aria-valuetext": words });
}

/** Return a moment (ms) and the length of the recording in words. */
function momentWords(at: number, length: number): string {
  return gettext("{at} of {length}", { at: clock(Math.floor(at / 1000)), length: clock(Math.floor(length / 1000)) });
}

function draw(): void {
  if (!player) return;
  const { at, length } = player;
  say(button, player.playing ? gettext("Pause") : gettext("Play"));
  const step = at >= length ? Number(range.max) : Math.round(at / STEP_MS) * STEP_MS;
  if (!held && Number(range.value) !== step) range.value = String(step);
  const words = momentWords(at, length);
  if (!player.playing || player.waiting) tellValue(words); // while it plays, each second would be read out
  say(time, words);
  tellWaiting(player.waiting);
  follow(at);
}

/** Say that it loads, if that takes long. */
function tellWaiting(waiting: boolean): void {
  if (waiting && said.textContent === FAILED) say(said, ""); // a moment is asked for again
  if (waiting && !loading) loading = window.setTimeout(() => say(said, LOADING), LONG_MS);
  if (waiting || !loading) return;
  clearTimeout(loading);
  loading = 0;
  if (said.textContent === LOADING) say(said, "");
}

/** Mark in the list the newest moment that has been reached. */
function follow(at: number): void {
  const list = byId("replay-list");
  const items = [...list.querySelectorAll<HTMLElement>("button")];
  const last = items.filter((item) => Number(item.dataset["at"]) <= at).at(-1) ?? null;
  const current = list.querySelector("[aria-current]");
  if (current === last) return;
  current?.removeAttribute("aria-current");
  last?.setAttribute("aria-current", "true");
}

function show(marks: readonly Mark[], length: number): void {
  const drawing = byId<SVGSVGElement>("replay-marks");
  byId("replay-list").replaceChildren(
    ...marks.map(({ at, text, bad }) => {
      const x = length ? (WIDE * at) / length : 0;
      shape(drawing, "rect", { x: Math.min(WIDE - 3, x), y: 0, width: 3, height: 10, class: bad ? "bad" : "" });
      const attributes = { type: "button", class: bad ? "linklike bad" : "linklike", "data-at": at };
      const jump = make("button", attributes, make("span", {}, clock(Math.floor(at / 1000))), ` ${text}`);
      jump.addEventListener("click", () => void player?.seek(at));
      return make("li", {}, jump);
    }),
  );
}

/** Show the moment that the address names, as `#at=12.5` (s); other pages link to it. */
function seekToAddress(): void {
  const found = /^#at=(\d{1,6}(?:\.\d{1,3})?)$/.exec(location.hash);
  if (found) void player?.seek(Number(found[1]) * 1000);
}

/** Return the index of the recording, asked for until it comes; null if the file is gone. */
async function readIndex(): Promise<Index | null> {
  for (;;) {
    try {
      const answer = await request(about.index, {}, FILE_MS);
      if (answer.status === 404) return null;
      if (answer.ok) return (await answer.json()) as Index;
    } catch {
      // there is no connection: as after an answer that is an error
    }
    say(said, UNREAD);
    await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
  }
}

async function begin(handlers: Handlers, opened: (player: Player) => void): Promise<void> {
  const index = await readIndex();
  say(said, index ? "" : GONE);
  if (!index) return;
  const story = new Story(index, about);
  player = new Player(index, about.slices, story, draw, () => say(said, FAILED));
  opened(player);
  range.max = String(Math.ceil(player.length / STEP_MS) * STEP_MS); // the last step is the end itself
  show(story.marks(), player.length);
  if (index.end) {
    const time = clock(Math.floor(player.length / 1000));
    say(byId("replay-end"), `${gettext("It ends at {time}.", { time })} ${translate(index.end)}`);
    byId("replay-end").hidden = false;
  }
  for (const control of [button, range, speed]) control.disabled = false;
  if (about.said) say(said, translate(about.said));
  player.attach(handlers);
  if (about.start) void player.seek(Math.min(about.start, player.length));
  seekToAddress();
  window.addEventListener("hashchange", seekToAddress);
  draw();
}

function toggle(): void {
  say(said, "");
  player?.play(!player.playing);
}

button.addEventListener("click", toggle);
share(
  () => Math.floor((player?.at ?? 0) / 1000),
  (words) => say(said, words),
);
// a range input has no use for Space, and Home, End and the arrows move it; buttons and lists keep their own keys
range.addEventListener("keydown", (event) => {
  if (event.key !== " " || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  if (!event.repeat) toggle();
});
range.addEventListener("input", () => {
  say(said, "");
  clearTimeout(moved);
  const at = Number(range.value);
  if (player) tellValue(momentWords(at, player.length));
  moved = window.setTimeout(() => void player?.seek(at), 30); // while it is dragged many come
});
range.addEventListener("pointerdown", () => (held = true));
for (const end of ["change", "pointerup", "pointercancel", "blur"]) range.addEventListener(end, () => (held = false));
speed.addEventListener("change", () => {
  if (player) player.speed = Number(speed.value);
});

/** The connection of the page: it keeps the choice of cameras until the index has come and there is a player. */
useRecording((_, handlers) => {
  let inner: Player | null = null;
  let wish: object | null = null;
  begin(handlers, (made) => {
    inner = made;
    if (wish) made.send(wish);
  }).catch(() => say(said, FAILED));
  return {
    ...CONNECTED,
    now: () => inner?.now() ?? 0,
    heardSince: () => false,
    check: () => undefined,
    send: (message) => {
      if ("t" in message && message.t === "watch") wish = message;
      return inner?.send(message) ?? wish === message;
    },
  };
});
