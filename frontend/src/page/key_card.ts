/** The list of keys: it moves nothing, all keys work while it is open, and it closes for the release of a stop. */
import { byId } from "../kit/dom.ts";

const card = byId<HTMLDialogElement>("keys");
const opener = byId("keys-open");

function toggle(): void {
  if (card.open) card.close();
  else card.show();
}

opener.addEventListener("click", toggle);
opener.setAttribute("aria-expanded", "false");
new MutationObserver(() => opener.setAttribute("aria-expanded", String(card.open))).observe(card, { attributeFilter: ["open"] });
new MutationObserver(() => byId("release").hidden || card.close()).observe(byId("release"), { attributeFilter: ["hidden"] });
byId("stage").addEventListener("keydown", (event) => {
  const field = (event.target as HTMLElement).closest("input, textarea, select, [contenteditable]");
  if (event.key !== "?" || field || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  toggle();
});
card.addEventListener("keydown", (event) => {
  if (event.key !== "Escape") return;
  event.stopPropagation(); // it closes the list and must not stop the robot
  card.close();
});
