/** The newest entries of the operator's log beside the picture. */
import { html, nothing, type TemplateResult } from "lit-html";
import { repeat } from "lit-html/directives/repeat.js";
import { draw } from "../kit/render.ts";
import { ago } from "../kit/times.ts";
import type { LogInfo } from "../socket/messages.ts";

export class LogList {
  constructor(private list: HTMLElement) {}

  draw(entries: readonly LogInfo[], now: number): void {
    draw(
      this.list,
      repeat(
        entries,
        ({ id }) => id,
        (entry) => item(entry, now),
      ),
    );
  }
}

function item({ author, at_ms, text, picture }: LogInfo, now: number): TemplateResult {
  const image = picture ? html`<img width="96" height="82" src=${picture} alt=${`Picture chosen by ${author}`}>` : nothing;
  return html`<li>${image}<b>${author}</b><time>${` ${ago(now - at_ms)} ago`}</time><p>${text}</p></li>`;
}
