/** A turn's page without a recording: its pictures one after the other, each with what the command before it did. */
import { byId, say, set } from "../kit/dom.ts";

const list = document.querySelector<HTMLElement>(".steps:not([data-replays])");
const stepper = document.getElementById("stepper");
const shown = [...(list?.children ?? [])].filter((step) => step.querySelector("a.after img"));

function words(step: Element, at: number): string {
  return `${at + 1} of ${shown.length}: ${step.querySelector(".words")?.textContent ?? ""}`;
}

if (list && stepper && shown.length > 1) {
  const buttons = [...stepper.querySelectorAll<HTMLButtonElement>("button")];
  let at = 0;
  const address = (index: number): string => shown[index]?.querySelector("img")?.getAttribute("src") ?? "";
  const draw = (): void => {
    const step = shown[at];
    if (!step) return;
    set(byId("stepper-picture"), { src: address(at), alt: step.querySelector("img")?.alt ?? "" });
    say(byId("stepper-said"), words(step, at));
    for (const one of shown) one.toggleAttribute("data-shown", one === step);
    if (at + 1 < shown.length) new Image().src = address(at + 1);
  };
  for (const button of buttons)
    button.addEventListener("click", () => {
      at = (at + Number(button.dataset["by"]) + shown.length) % shown.length; // after the last one the first follows
      draw();
    });
  stepper.hidden = false;
  draw();
}
