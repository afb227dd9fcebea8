/** Plain words for a robot's own ones, of the table `words` of its robot.toml; its own stand beside them, small. */
import { html, type TemplateResult } from "lit-html";
import { draw } from "../kit/render.ts";
import { translate } from "../kit/text.ts";
import { facts } from "./facts.ts";

/** Return the plain word, or the robot's own where it has none. */
export function plain(own: string): string {
  return facts.words?.[own] ?? translate(own);
}

/** Return the plain word, and then the robot's own where it is another. What follows a colon stays as it is. */
export function worded(told: string): TemplateResult {
  const [own = "", ...rest] = told.split(": ");
  const words = facts.words?.[own];
  return words === undefined
    ? html`${translate(told)}`
    : html`${[words, ...rest.map(translate)].join(": ")} <small translate="no">${own}</small>`;
}

export function sayWord(element: HTMLElement, told: string): void {
  draw(element, worded(told));
}
