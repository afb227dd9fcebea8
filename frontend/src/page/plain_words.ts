/** Plain words for a robot's own ones, of the table `words` of its robot.toml; its own stand beside them, small. */
import { html, type TemplateResult } from "lit-html";
import { draw } from "../kit/render.ts";
import { facts } from "./facts.ts";

/** Return the plain word, or the robot's own where it has none. */
export function plain(own: string): string {
  return facts.words?.[own] ?? own;
}

/** Return the plain word, and then the robot's own where it is another. What follows a colon stays as it is. */
export function worded(told: string): TemplateResult {
  const [own = "", ...rest] = told.split(": ");
  const word = plain(own);
  return word === own ? html`${told}` : html`${[word, ...rest].join(": ")} <small>${own}</small>`;
}

export function sayWord(element: HTMLElement, told: string): void {
  draw(element, worded(told));
}
