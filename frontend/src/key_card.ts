/** The card of keys: it stands in the page, covers nothing, and every key works beside it. */
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
  event.stopPropagation(); // it closes the card, and stops no robot
  card.close();
  opener.focus();
});
