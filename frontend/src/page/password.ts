/** A button that shows a new password: it is written once, so one can look at it. */
import { gettext } from "../kit/text.ts";

for (const field of document.querySelectorAll<HTMLInputElement>('input[autocomplete="new-password"]')) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "linklike show-password";
  button.textContent = gettext("Show the password");
  button.setAttribute("aria-controls", field.id);
  button.setAttribute("aria-pressed", "false");
  button.addEventListener("click", () => {
    const shown = field.type === "password";
    field.type = shown ? "text" : "password";
    button.setAttribute("aria-pressed", String(shown));
  });
  field.form?.addEventListener("submit", () => (field.type = "password")); // so that browsers offer to store it
  field.after(button);
}
