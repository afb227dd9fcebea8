/** The page of the admin on which a moderator decides about entries: its keys. */
import "./review.css";
import { byId } from "../kit/dom.ts";
import { storage } from "../kit/storage.ts";

const TYPING = "textarea, select, [contenteditable], input:not([type=radio], [type=checkbox])";
const OFF = "off";

const desk = byId("desk"),
  list = document.getElementById("keys"),
  choice = document.getElementById("keys-on") as HTMLInputElement | null;

function offer(): void {
  desk.classList.toggle("by-keys", choice?.checked);
  for (const one of desk.querySelectorAll<HTMLElement>("[data-key]"))
    if (choice?.checked) one.setAttribute("aria-keyshortcuts", (one.dataset["key"] ?? "").toUpperCase());
    else one.removeAttribute("aria-keyshortcuts");
}

function press(found: HTMLElement): void {
  if (found instanceof HTMLInputElement) found.focus();
  if (found instanceof HTMLFieldSetElement) found.querySelector<HTMLElement>("input:checked")?.focus();
  else found.click();
}

desk.addEventListener("keydown", (event) => {
  const at = event.target as HTMLElement;
  if (event.key === "Escape") desk.focus();
  if (!choice?.checked || event.repeat || event.ctrlKey || event.metaKey || event.altKey || at.closest(TYPING)) return;
  const found = desk.querySelector<HTMLElement>(`[data-key="${CSS.escape(event.key.toLowerCase())}"]`);
  if (!found) return;
  event.preventDefault();
  press(found);
});

if (list && choice) {
  list.hidden = false; // there are keys
  choice.checked = storage.get("review-keys") !== OFF;
  choice.addEventListener("change", () => {
    storage.set("review-keys", choice.checked ? "on" : OFF);
    offer();
  });
  offer();
}
desk.focus({ preventScroll: true });
