/** Controls that are disabled with a reason: they stay where they are and keep the focus, and a press shows the reason. */
import { set } from "./dom.ts";
import { gettext } from "./text.ts";

/** Enable a control, or disable it with a reason, which a press shows. Place and focus stay. */
export function allow(control: HTMLElement, why: string): void {
  set(control, { "aria-disabled": String(why !== ""), "data-why": why });
}

/** Return why a control is disabled; empty if it is enabled. */
export function refusal(control: HTMLElement): string {
  return control.getAttribute("aria-disabled") === "true" ? control.dataset["why"] || gettext("That does not work now.") : "";
}
