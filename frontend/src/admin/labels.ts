/** Names for what Django's own scripts put into the admin's forms. */

function giveNames(): void {
  // where a row is searched for (select2): the label, and what was chosen
  for (const shown of document.querySelectorAll<HTMLElement>(".select2-selection__rendered")) {
    const field = shown.closest(".select2-container")?.previousElementSibling,
      label = document.querySelector<HTMLLabelElement>(`label[for="${field?.id ?? ""}"]`);
    if (!label) continue;
    label.id ||= `${label.htmlFor}_label`;
    shown.setAttribute("aria-labelledby", label.id);
    shown.closest(".select2-selection")?.setAttribute("aria-labelledby", `${label.id} ${shown.id}`);
  }
  for (const icon of document.querySelectorAll(".help-tooltip[aria-label]")) icon.setAttribute("role", "img"); // two lists of rows
}

addEventListener("load", () => setTimeout(giveNames)); // jQuery lets what waits for the page begin by a timer of its own
