/** The page after a turn: keeps a draft of the entry, so that a lost line loses nothing. */

const area = document.querySelector<HTMLTextAreaElement>("textarea[data-draft]");
if (area) {
  const key = `draft-${area.dataset["draft"]}`;
  if (!area.value) area.value = localStorage.getItem(key) ?? "";
  area.addEventListener("input", () => localStorage.setItem(key, area.value));
  area.form?.addEventListener("submit", () => localStorage.removeItem(key));
}
