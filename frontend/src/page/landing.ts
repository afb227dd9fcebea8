/** The landing page: a card for each robot, one of them large, with the pictures of the last turn while it rests. */
import { LiveCard, offerPause } from "./live_card.ts";

const pictures = document.getElementById("loop")?.textContent;
const cards = [...document.querySelectorAll<HTMLElement>("[data-live]")].map(
  (card) => new LiveCard(card, pictures && card.matches(".lead") ? (JSON.parse(pictures) as string[]) : []),
);
if (cards.length) offerPause(() => cards);
