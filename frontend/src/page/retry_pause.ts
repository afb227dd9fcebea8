/** A link that is disabled until a pause is over; it shows a countdown. */
import { every } from "../kit/page_clock.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { clock } from "../kit/times.ts";
import { gettext } from "../kit/text.ts";

for (const link of document.querySelectorAll<HTMLAnchorElement>("a[data-pause]")) {
  const until = Date.now() + Number(link.dataset["pause"]) * 1000;
  const words = link.textContent;
  const said = document.getElementById("pause-said");
  const left = (): number => (until - Date.now()) / 1000;
  const draw = (): void => {
    const waits = left() > 0;
    link.textContent = waits ? gettext("{action} in {time}", { action: words, time: clock(left()) }) : words;
    allow(link, waits ? gettext("You can try again when the time is over.") : "");
    if (waits) return;
    end();
    if (said) said.textContent = gettext("You can try again now.");
  };
  link.addEventListener("click", (event) => refusal(link) && event.preventDefault());
  const end = every(500, draw);
  draw();
}
