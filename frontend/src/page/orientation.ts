import "../style/orientation.css";
/** The orientation: the picture points at the control that the reader looks at in the text. */

const marks = document.querySelectorAll<SVGGElement>(".tour g[data-number]");

function point(number: string | undefined): void {
  for (const mark of marks) mark.classList.toggle("pointed", mark.dataset["number"] === number);
}

for (const part of document.querySelectorAll<HTMLElement>(".tour .prose :is(li, p)")) {
  const number = part.querySelector<HTMLElement>(".control")?.dataset["number"];
  part.addEventListener("pointerenter", () => point(number));
  part.addEventListener("pointerleave", () => point(undefined));
}
