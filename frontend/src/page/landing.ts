/** The landing page: each robot's thumbnail follows its newest picture, and says when it is not live. */
import { make, set } from "../kit/dom.ts";
import { every } from "../kit/page_clock.ts";
import { LIVE_MS, isLive } from "../media/pictures.ts";
import type { Message } from "../socket/messages.ts";
import type { PicturePacket } from "../socket/packets.ts";
import { RobotSocket } from "../socket/robot_socket.ts";

for (const card of document.querySelectorAll<HTMLElement>("[data-live]")) {
  let picture = card.querySelector<HTMLImageElement>("img");
  const status = card.querySelector<HTMLElement>(".pill");
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const name = card.querySelector(".name")?.textContent ?? "the robot";
  const mark = make("span", { class: "not-live" }, "Not live");
  let last = 0;
  let taken = 0; // when the last live picture was taken, by the server's clock (ms)
  let came = -Infinity; // when it came, by this page's clock (ms)
  /** Return the image element; a robot without a stored picture gets one with its first picture. */
  const place = (): HTMLImageElement => {
    if (!picture) {
      picture = new Image();
      card.querySelector(".thumb")?.replaceChildren(picture);
    }
    return picture;
  };
  const live = new RobotSocket(
    card.dataset["live"] ?? "",
    {
      message(m: Message) {
        if (m.t !== "snapshot") return;
        if (status) status.textContent = m.robot.label;
        card.dataset["state"] = m.robot.state;
        if (m.still && (calm || !last)) place().src = m.still.url;
        judge();
      },
      state() {},
      picture(packet: PicturePacket) {
        if (calm || packet.camera !== 0 || packet.number === last) return;
        last = packet.number;
        [taken, came] = [packet.atMs, performance.now()];
        const old = place().src;
        place().src = URL.createObjectURL(packet.jpeg);
        if (old.startsWith("blob:")) URL.revokeObjectURL(old);
        judge();
      },
      line: () => judge(),
    },
    () => 15_000,
    null,
    () => ({ t: "watch", cameras: calm ? [] : [0], every_s: 1, compact: true }),
  );
  /** Mark a picture that is old, or whose age is not known because the server is not reached. */
  const judge = (): void => {
    if (!picture) return;
    const now = performance.now() - came < LIVE_MS && isLive(live.now() - taken, live.lost);
    card.dataset["picture"] = now ? "live" : "old";
    set(picture, { alt: `What ${name}'s camera ${now ? "sees now" : "saw last"}` });
    if (now) mark.remove();
    else if (!mark.isConnected) card.querySelector(".thumb")?.append(mark);
  };
  every(1000, judge);
}
