/** The landing page: each robot's thumbnail follows its newest picture. */
import { Live } from "./live.ts";
import type { Message, PicturePacket } from "./protocol.ts";

for (const card of document.querySelectorAll<HTMLElement>("[data-live]")) {
  let picture = card.querySelector<HTMLImageElement>("img");
  const status = card.querySelector<HTMLElement>(".pill");
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let last = 0;
  /** A robot without a stored picture gets an image element with its first picture. */
  const place = (): HTMLImageElement => {
    if (!picture) {
      picture = new Image();
      picture.alt = `What ${card.querySelector(".name")?.textContent ?? "the robot"}'s camera sees now`;
      card.querySelector(".thumb")?.replaceChildren(picture);
    }
    return picture;
  };
  new Live(
    card.dataset["live"] ?? "",
    {
      message(m: Message) {
        if (m.t !== "snapshot") return;
        if (status) status.textContent = m.robot.label;
        card.dataset["state"] = m.robot.state;
        if (m.still && (calm || !last)) place().src = m.still.url;
      },
      state() {},
      picture(packet: PicturePacket) {
        if (calm || packet.camera !== 0 || packet.number === last) return;
        last = packet.number;
        const old = place().src;
        place().src = URL.createObjectURL(packet.jpeg);
        if (old.startsWith("blob:")) URL.revokeObjectURL(old);
      },
      line() {},
    },
    () => 15_000,
    null,
    () => ({ t: "watch", cameras: calm ? [] : [0], every_s: 1, compact: true }),
  );
}
