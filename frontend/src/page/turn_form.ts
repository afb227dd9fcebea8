/** The page after a turn: a draft of the form is stored on this device until the server has it, and its link is copied. */
import { copy } from "../kit/copy.ts";
import { byId, say } from "../kit/dom.ts";
import { withStorage } from "../kit/storage.ts";
import { gettext } from "../kit/text.ts";

const turn = document.querySelector<HTMLElement>("[data-drafts-of]")?.dataset["draftsOf"] ?? "";
const form = document.querySelector<HTMLFormElement>("form[data-draft]");
const nameOf = (draft: string): string => `draft-${draft}`;

/** Return the filled-in values by name, without the form's token. */
function filled(of: HTMLFormElement): Record<string, string> {
  const all = [...new FormData(of)].filter(([name]) => name !== "csrfmiddlewaretoken");
  return Object.fromEntries(all.map(([name, value]) => [name, typeof value === "string" ? value : value.name]));
}

/** Return the stored draft; empty if there is none, or it cannot be read. */
function read(name: string): Record<string, string> {
  return withStorage((all) => JSON.parse(all.getItem(name) ?? "{}") as Record<string, string>) ?? {};
}

/** Return the names of the fields in which something was filled in before this script ran. */
function touched(of: HTMLFormElement): Set<string> {
  const found = new Set<string>();
  for (const field of of.elements)
    if (field instanceof HTMLInputElement || field instanceof HTMLTextAreaElement) {
      const checked = field instanceof HTMLInputElement && field.checked !== field.defaultChecked;
      if (checked || field.value !== field.defaultValue) found.add(field.name);
    }
  return found;
}

/** Fill in the draft, except in the fields that somebody has begun to fill in. */
function fill(of: HTMLFormElement, draft: Record<string, string>, begun: Set<string>): void {
  for (const [name, value] of Object.entries(draft)) {
    if (begun.has(name)) continue;
    const field = of.elements.namedItem(name);
    if (field instanceof HTMLTextAreaElement || field instanceof RadioNodeList || field instanceof HTMLInputElement) field.value = value;
  }
}

/** Fill in the place of a find from the chosen picture, until somebody has typed another. */
function fillPlace(of: HTMLFormElement): void {
  const chosen = of.querySelector<HTMLInputElement>("input[name=frame]:checked");
  for (const axis of ["x", "y"]) {
    const field = of.querySelector<HTMLInputElement>(`#find_${axis}`);
    const place = chosen?.dataset[axis] ?? "";
    if (!field || (field.value !== "" && field.value !== field.dataset["filled"])) continue;
    field.value = field.dataset["filled"] = place;
  }
}

if (form) {
  const name = nameOf(form.dataset["draft"] ?? "");
  const begun = touched(form);
  const store = (): void =>
    withStorage((all) => {
      all.setItem(name, JSON.stringify(filled(form)));
      document.getElementById("draft-said")?.removeAttribute("hidden");
    });
  if ("fresh" in form.dataset) fill(form, read(name), begun); // after a refusal the server returns what was sent
  if (begun.size) store();
  form.addEventListener("input", store);
  form.addEventListener("change", () => fillPlace(form));
  fillPlace(form);
}
const share = document.getElementById("share");
if (share) {
  share.hidden = false;
  share.addEventListener("click", () => {
    void copy(share.dataset["link"] ?? "", gettext("The link was copied."), (words) => say(byId("share-said"), words));
  });
}
// the server has accepted what was in the forms before, whose drafts have other names
withStorage((all) => {
  const present = form && nameOf(form.dataset["draft"] ?? "");
  for (const name of Object.keys(all)) if (name !== present && `${name}-`.startsWith(`${nameOf(turn)}-`)) all.removeItem(name);
});
