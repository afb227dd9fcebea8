/** The landing page: each robot's thumbnail follows its newest picture. */
import { Live } from "./live.ts";
import type { Message, PicturePacket } from "./protocol.ts";

for (const card of document.querySelectorAll<HTMLElement>("[data-live]")) {
  const picture = card.querySelector<HTMLImageElement>("img");
  const status = card.querySelector<HTMLElement>(".pill");
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let last = 0;
  new Live(
    card.dataset["live"] ?? "",
    {
      message(m: Message) {
        if (m.t !== "snapshot") return;
        if (status) status.textContent = m.robot.label;
        card.dataset["state"] = m.robot.state;
        if (picture && m.still && (calm || !last)) picture.src = m.still.url;
      },
      state() {},
      picture(packet: PicturePacket) {
        if (!picture || calm || packet.camera !== 0 || packet.number === last) return;
        last = packet.number;
        const old = picture.src;
        picture.src = URL.createObjectURL(packet.jpeg);
        if (old.startsWith("blob:")) URL.revokeObjectURL(old);
      },
      line() {},
    },
    () => 15_000,
  );
}
