/** A robot's card: its picture follows its newest one, and says when it is not live. */
import { byId, make, say, set } from "../kit/dom.ts";
import { shownName } from "../kit/names.ts";
import { every } from "../kit/page_clock.ts";
import { gettext, translate } from "../kit/text.ts";
import { LIVE_MS, isLive } from "../media/pictures.ts";
import { joinWait } from "../queue/waits.ts";
import type { Message, Snapshot } from "../socket/messages.ts";
import type { PicturePacket } from "../socket/packets.ts";
import { RobotSocket } from "../socket/robot_socket.ts";

const LARGE_S = 0.2, // the least time between two pictures of a large robot that moves
  SMALL_S = 1; // of any other
const LOOP_MS = 1000; // how long a picture of the last turn is shown
const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
let paused = calm; // whether pictures change only when somebody asks

export class LiveCard {
  private readonly picture: HTMLImageElement;
  private readonly mark = make("span", { class: "not-live" }, gettext("Not live"));
  private readonly name: string;
  private last = 0;
  private taken = 0; // when the last live picture was taken, by the server's clock (ms)
  private came = -Infinity; // when it came, by this page's clock (ms)
  private moves = false; // something moves the robot
  private asked = ""; // the newest wish
  private readonly live: RobotSocket;

  /** `loop`: the pictures of the last turn, which are shown until the robot moves. `changed`: something about it has. */
  constructor(
    private readonly card: HTMLElement,
    private loop: readonly string[] = [],
    private readonly changed: () => void = () => undefined,
  ) {
    this.name = card.querySelector(".name")?.textContent ?? gettext("the robot");
    this.picture = card.querySelector("img") ?? new Image();
    this.live = new RobotSocket(
      card.dataset["live"] ?? "",
      {
        message: (m: Message) => m.t === "snapshot" && this.tell(m),
        state() {},
        picture: (packet: PicturePacket) => this.show(packet),
        line: () => this.judge(),
      },
      () => 15_000,
      null,
      () => this.wish(),
    );
    every(LOOP_MS, () => this.beat());
    document.addEventListener("visibilitychange", () => this.ask());
  }

  /** Ask for what is needed now, and for nothing that nobody sees. */
  ask(): void {
    const before = this.asked,
      wish = this.wish();
    if (this.asked !== before) this.live.send(wish);
  }

  private wish(): object {
    const wish = {
      t: "watch",
      cameras: paused || document.hidden || this.loop.length ? [] : [0],
      every_s: this.moves && this.card.matches(".lead") ? LARGE_S : SMALL_S,
      compact: true,
    };
    this.asked = JSON.stringify(wish);
    return wish;
  }

  private tell(m: Snapshot): void {
    const { card } = this,
      { robot } = m;
    const words = {
      pill: translate(robot.label),
      drives: m.operator ? gettext("{name} drives", { name: shownName(m.operator) }) : "",
      wait: robot.turns && !m.turn?.mine && !m.me.ticket ? joinWait(robot.state, robot.free ?? false, m.join_wait_s ?? null) : "",
    };
    for (const [name, text] of Object.entries(words)) {
      const part = card.querySelector(`.${name}`);
      if (part) say(part, text);
    }
    card.dataset["state"] = robot.state;
    this.moves = robot.moves ?? false;
    if (this.moves) this.loop = []; // its pictures are those of the turn before, from now on
    card.toggleAttribute("data-loop", this.loop.length > 0);
    this.ask();
    if (m.still && !this.loop.length && (paused || !this.last)) this.place(m.still.url);
    this.judge();
    this.changed();
  }

  private show(packet: PicturePacket): void {
    if (paused || this.loop.length || packet.camera !== 0 || packet.number === this.last) return;
    this.last = packet.number;
    [this.taken, this.came] = [packet.atMs, performance.now()];
    this.place(URL.createObjectURL(packet.jpeg));
    this.judge();
  }

  private beat(): void {
    if (this.loop.length && !paused && !document.hidden) {
      const at = this.loop.indexOf(new URL(this.picture.src, location.href).pathname);
      this.place(this.loop[(at + 1) % this.loop.length] ?? "");
    }
    this.judge();
  }

  private place(url: string): void {
    const { picture } = this;
    const old = picture.src;
    picture.src = url;
    if (old.startsWith("blob:")) URL.revokeObjectURL(old);
    if (!picture.isConnected) this.card.querySelector(".thumb")?.replaceChildren(picture);
  }

  /** Mark a picture that is old, or whose age is not known because the server is not reached. */
  private judge(): void {
    const { picture } = this;
    if (!picture.isConnected) return;
    const now = performance.now() - this.came < LIVE_MS && isLive(this.live.now() - this.taken, this.live.lost);
    this.card.dataset["picture"] = now ? "live" : "old";
    const { name } = this;
    const alt = this.loop.length
      ? gettext("What {name}'s camera saw in the last turn", { name })
      : now
        ? gettext("What {name}'s camera sees now", { name })
        : gettext("What {name}'s camera saw last", { name });
    set(picture, { alt });
    if (now) this.mark.remove();
    else if (!this.mark.isConnected) this.card.querySelector(".thumb")?.append(this.mark);
  }
}

/** Show the button that pauses the pictures of these cards; with reduced motion they are paused anyway. */
export function offerPause(cards: () => Iterable<LiveCard>): void {
  if (calm) return;
  const pause = byId("pause");
  pause.hidden = false;
  pause.addEventListener("click", () => {
    paused = !paused;
    set(pause, { "aria-pressed": String(paused) });
    for (const card of cards()) card.ask();
  });
}
