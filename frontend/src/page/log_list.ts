/** The newest entries of the operator's log beside the picture. */
import { html, nothing } from "lit-html";
import { drawParts, type Part } from "../kit/render.ts";
import { ago } from "../kit/times.ts";
import { shownName } from "../kit/names.ts";
import { gettext } from "../kit/text.ts";
import type { LogInfo } from "../socket/messages.ts";

/** Show these entries; `now`: server time (ms). */
export function drawLog(list: HTMLElement, entries: readonly LogInfo[], now: number): void {
  const parts = entries.map(({ id, author: handle, at_ms, text, picture }): Part => {
    const author = shownName(handle);
    const image = picture
      ? html`<img width="96" height="82" src=${picture} alt=${gettext("Picture chosen by {author}", { author })}>`
      : nothing;
    return {
      key: id,
      template: html`<li>${image}<b>${author}</b><time>${` ${gettext("{time} ago", { time: ago(now - at_ms) })}`}</time><p>${text}</p></li>`,
    };
  });
  drawParts(list, parts);
}
