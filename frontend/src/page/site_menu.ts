/** The menu of every page: its list of robots closes by Escape and by a press elsewhere, as a menu does. */

const menu = document.getElementById("menu");
const robots = document.querySelector<HTMLDetailsElement>(".menu-robots");

document.addEventListener("click", ({ target }) => {
  if (robots?.open && !robots.contains(target as Node)) robots.open = false;
});
robots?.addEventListener("focusout", ({ relatedTarget }) => {
  if (relatedTarget && !robots.contains(relatedTarget as Node)) robots.open = false;
});
// a page that asks before it is left must be seen
menu?.addEventListener("click", ({ target }) => {
  if ((target as Element).closest("a") && menu.matches(":popover-open")) menu.hidePopover();
});
menu?.addEventListener("keydown", (event) => {
  if (event.key !== "Escape" || !robots?.open) return;
  event.preventDefault();
  robots.open = false;
  robots.querySelector("summary")?.focus();
});
