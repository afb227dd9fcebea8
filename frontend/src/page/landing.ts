/** The landing page: each robot's picture follows its newest one, and says when it is not live; one robot is large. */
import { make, say, set } from "../kit/dom.ts";
import { every } from "../kit/page_clock.ts";
import { LIVE_MS, isLive } from "../media/pictures.ts";
import { joinWait } from "../queue/waits.ts";
import type { Message, Snapshot } from "../socket/messages.ts";
import type { PicturePacket } from "../socket/packets.ts";
import { RobotSocket } from "../socket/robot_socket.ts";

const EVERY_S = { large: 0.2, small: 1 }; // the least time between two pictures
const LOOP_MS = 1000; // how long a picture of the last turn is shown
const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;

class LiveCard {
  private readonly picture: HTMLImageElement;
  private readonly mark = make("span", { class: "not-live" }, "Not live");
  private readonly name: string;
  private last = 0;
  private taken = 0; // when the last live picture was taken, by the server's clock (ms)
  private came = -Infinity; // when it came, by this page's clock (ms)
  private readonly live: RobotSocket;

  constructor(
    private readonly card: HTMLElement,
    private readonly loop: readonly string[] = [],
  ) {
    this.name = card.querySelector(".name")?.textContent ?? "the robot";
    this.picture = card.querySelector("img") ?? new Image();
    const every_s = card.matches(".lead") ? EVERY_S.large : EVERY_S.small;
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
      () => ({ t: "watch", cameras: calm ? [] : [0], every_s, compact: true }),
    );
    every(1000, () => this.judge());
    if (!calm && loop.length) every(LOOP_MS, () => this.turnOver());
  }

  /** Whether the robot moves, so that its live picture is shown and not the last turn's. */
  private get moves(): boolean {
    return this.card.dataset["state"] === "operating";
  }

  private get looping(): boolean {
    return !calm && this.loop.length > 0 && !this.moves;
  }

  private tell(m: Snapshot): void {
    const { card } = this;
    const words = {
      pill: m.robot.label,
      drives: m.operator ? `${m.operator} drives` : "",
      wait: m.robot.turns ? joinWait(m.robot.state, m.queue, m.join_wait_s ?? null) : "",
    };
    for (const [name, text] of Object.entries(words)) {
      const part = card.querySelector(`.${name}`);
      if (part) say(part, text);
    }
    card.dataset["state"] = m.robot.state;
    card.toggleAttribute("data-loop", this.looping);
    if (m.still && !this.looping && (calm || !this.last)) this.place(m.still.url);
    this.judge();
  }

  private show(packet: PicturePacket): void {
    if (calm || packet.camera !== 0 || packet.number === this.last) return;
    this.last = packet.number;
    [this.taken, this.came] = [packet.atMs, performance.now()];
    if (!this.looping) this.place(URL.createObjectURL(packet.jpeg));
    this.judge();
  }

  /** Show the next picture of the last turn. */
  private turnOver(): void {
    if (!this.looping) return;
    const at = this.loop.indexOf(new URL(this.picture.src, location.href).pathname);
    this.place(this.loop[(at + 1) % this.loop.length] ?? "");
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
    if (!picture.isConnected || this.looping) {
      this.mark.remove();
      return;
    }
    const now = performance.now() - this.came < LIVE_MS && isLive(this.live.now() - this.taken, this.live.lost);
    this.card.dataset["picture"] = now ? "live" : "old";
    set(picture, { alt: `What ${this.name}'s camera ${now ? "sees now" : "saw last"}` });
    if (now) this.mark.remove();
    else if (!this.mark.isConnected) this.card.querySelector(".thumb")?.append(this.mark);
  }
}

const pictures = document.getElementById("loop")?.textContent;
for (const card of document.querySelectorAll<HTMLElement>("[data-live]"))
  new LiveCard(card, pictures && card.matches(".lead") ? (JSON.parse(pictures) as string[]) : []);
