/** A page that another site shows in a frame: pictures of a recording, one a second, or a robot's newest picture. */
import "../style/index.css";
import "../style/embed.css";
import { gettext } from "../kit/text.ts";

const ROBOT_MS = 3000,
  STEP_MS = 1000;
const still = document.querySelector<HTMLImageElement>("#picture");
const facts = document.getElementById("embed-facts");

let asked = 0; // pictures; an older one that comes late is not shown

/** Show an address when it has been loaded, so that the old picture stays until then. */
function show(address: string): Promise<void> {
  const number = ++asked;
  return new Promise((over) => {
    const next = new Image();
    next.addEventListener("load", () => {
      if (still && number === asked) still.src = address;
      over();
    });
    next.addEventListener("error", () => over());
    next.src = address;
  });
}

function live(address: string): void {
  const next = async (): Promise<void> => {
    if (!document.hidden) await show(`${address}?${Date.now()}`);
    window.setTimeout(() => void next(), ROBOT_MS);
  };
  window.setTimeout(() => void next(), ROBOT_MS);
}

function recorded(told: { pictures: string; length: number; at: number }): void {
  const play = document.querySelector<HTMLButtonElement>("#play"),
    bar = document.querySelector<HTMLInputElement>("#at");
  if (!play || !bar) return;
  let playing = false;
  const words = (): string => `${Math.floor(bar.valueAsNumber / 60)}:${String(bar.valueAsNumber % 60).padStart(2, "0")}`;
  const draw = async (): Promise<void> => {
    bar.setAttribute("aria-valuetext", words());
    await show(`${told.pictures}${bar.valueAsNumber}.jpg`);
  };
  const say = (): void => void (play.textContent = playing ? gettext("Pause") : gettext("Play"));
  const step = async (): Promise<void> => {
    if (!playing) return;
    if (bar.valueAsNumber >= told.length) playing = false;
    else {
      bar.value = String(bar.valueAsNumber + 1);
      const began = performance.now();
      await draw();
      window.setTimeout(() => void step(), Math.max(0, STEP_MS - (performance.now() - began)));
    }
    say();
  };
  play.addEventListener("click", () => {
    if (!playing && bar.valueAsNumber >= told.length) bar.value = "0";
    playing = !playing;
    say();
    void step();
  });
  bar.addEventListener("input", () => void draw());
  play.disabled = bar.disabled = false;
}

if (still?.dataset["live"]) live(still.dataset["live"]);
if (facts) recorded(JSON.parse(facts.textContent) as { pictures: string; length: number; at: number });
