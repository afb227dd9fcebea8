/** Draws templates of lit-html again and again; elements that are the same stay, with press, focus and reading position. */
import { html, noChange, nothing, render, type TemplateResult } from "lit-html";
import { Directive, directive, type ElementPart } from "lit-html/directive.js";
import { repeat } from "lit-html/directives/repeat.js";
import { allow } from "./refusal.ts";

const own = new WeakSet<Element>();

/** Show a template, or several, and nothing else in the box; the first drawing removes what the server put there. */
export function draw(box: HTMLElement, content: unknown): void {
  if (!own.has(box)) box.replaceChildren();
  own.add(box);
  render(content, box);
}

class Allow extends Directive {
  render(_why: string): unknown {
    return noChange;
  }

  override update(part: ElementPart, [why]: [string]): unknown {
    allow(part.element as HTMLElement, why);
    return noChange;
  }
}

/** As `allow`, for a control of a template: `<button ${allowed(why)}>`. */
export const allowed = directive(Allow);

/** A part of a page, or an item of a list: with the same key it stays the same element. */
export interface Part {
  key: string | number;
  template: TemplateResult;
}

/** Show these parts, and nothing else. Of several with the same key the first stays the first. */
export function drawParts(box: HTMLElement, parts: readonly Part[]): void {
  const count = new Map<string | number, number>();
  const unique = (part: Part): string => {
    const before = count.get(part.key) ?? 0;
    count.set(part.key, before + 1);
    return `${part.key} ${before}`;
  };
  const content = repeat(parts, unique, ({ template }) => template);
  draw(box, content);
}

export function heading(text: string): Part {
  return { key: "h2", template: html`<h2>${text}</h2>` };
}

export function paragraph(text: string, style = ""): Part {
  return { key: `p ${style}`, template: html`<p class=${style || nothing}>${text}</p>` };
}

export function strong(text: string): Part {
  return { key: "b", template: html`<b>${text}</b>` };
}

export function words(text: string, style = ""): Part {
  return { key: `span ${style}`, template: html`<span class=${style || nothing}>${text}</span>` };
}

/** A countdown in a paragraph of its own; it is not announced to screen readers every second. */
export function countdown(text: string): Part {
  return { key: "timer", template: html`<p class="timer" role="timer">${text}</p>` };
}

/** The same within a line of text. */
export function inlineCountdown(text: string, style: string): Part {
  return { key: `timer ${style}`, template: html`<span class=${style} role="timer">${text}</span>` };
}

export function link(text: string, href: string, style = ""): Part {
  return { key: `a ${href} ${style}`, template: html`<a class=${style || nothing} href=${href}>${text}</a>` };
}

/** A button: `action` is the name of what a press does, `why` the reason why it is disabled. */
export function button(
  text: string,
  action: string,
  { style = "", why = "", pressed }: { style?: string; why?: string; pressed?: boolean } = {},
): Part {
  return {
    key: `button ${action} ${style}`,
    template: html`<button type="button" class=${`${style} button`.trim()} data-do=${action} aria-pressed=${pressed === undefined ? nothing : String(pressed)} ${allowed(why)}>${text}</button>`,
  };
}

/** Parts that stand over those before them, and move nothing. */
export function bubble(parts: readonly Part[]): Part {
  return { key: "bubble", template: html`<div class="follows">${parts.map(({ template }) => template)}</div>` };
}

export type Cell = string | TemplateResult;

/** Write rows of words into a table's body; the first cell of each row is its heading. */
export function fill(body: HTMLTableSectionElement, rows: readonly (readonly Cell[])[]): void {
  const cells = (texts: readonly Cell[]): TemplateResult[] => texts.map((text) => html`<td>${text}</td>`);
  const content = rows.map(([first = "", ...rest]) => html`<tr><th scope="row">${first}</th>${cells(rest)}</tr>`);
  draw(body, content);
}
