/** The list of keys: it is part of the page, covers nothing, and all keys work while it is open. */
import { byId } from "./svg.ts";

const card = byId<HTMLDialogElement>("keys");
const opener = byId("keys-open");

export function openKeys(): void {
  if (!card.open) card.show();
  card.scrollIntoView({ block: "end" }); // on a phone picture and Stop lie over the upper half
}

opener.addEventListener("click", () => (card.open ? card.close() : openKeys()));
opener.setAttribute("aria-expanded", "false");
new MutationObserver(() => opener.setAttribute("aria-expanded", String(card.open))).observe(card, { attributeFilter: ["open"] });
card.addEventListener("keydown", (event) => {
  if (event.key !== "Escape") return;
  event.stopPropagation(); // it closes the list and must not stop the robot
  card.close();
  opener.focus();
});
