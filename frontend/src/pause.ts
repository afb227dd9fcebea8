/** A link that leads nowhere yet: it counts down, and works when its time has come. */
import { clock } from "./words.ts";

for (const link of document.querySelectorAll<HTMLAnchorElement>("a[data-pause]")) {
  const until = Date.now() + Number(link.dataset["pause"]) * 1000;
  const words = link.textContent ?? "";
  const said = document.getElementById("pause-said");
  const left = (): number => (until - Date.now()) / 1000;
  const draw = (): void => {
    const waits = left() > 0;
    link.textContent = waits ? `${words} in ${clock(left())}` : words;
    link.setAttribute("aria-disabled", String(waits));
    if (waits) return;
    clearInterval(timer);
    if (said) said.textContent = "You can try again now.";
  };
  link.addEventListener("click", (event) => left() > 0 && event.preventDefault());
  const timer = setInterval(draw, 500);
  draw();
}
