/** Copies a link to the moment that is shown, and the code by which another page shows the recording in a frame. */
import { copy } from "../kit/copy.ts";
import { gettext } from "../kit/text.ts";

/** Return a link to a second of a recording. */
export function linkTo(address: string, second: number): string {
  return second > 0 ? `${address}?t=${second}` : address;
}

/** Return the HTML of a frame with that address; `title` is what its screen readers say. */
export function frameOf(address: string, title: string): string {
  const text = title.replaceAll("&", "&amp;").replaceAll('"', "&quot;").replaceAll("<", "&lt;");
  return `<iframe src="${address}" title="${text}" width="640" height="480" loading="lazy" allowfullscreen></iframe>`;
}

/** Let the two buttons copy; `second` is the moment that is shown. */
export function share(second: () => number, tell: (words: string) => void): void {
  const link = document.getElementById("replay-share"),
    code = document.getElementById("replay-embed");
  link?.addEventListener("click", () => {
    void copy(linkTo(link.dataset["link"] ?? "", second()), gettext("The link was copied."), tell);
  });
  code?.addEventListener("click", () => {
    const address = linkTo(code.dataset["link"] ?? "", second());
    void copy(frameOf(address, code.dataset["title"] ?? ""), gettext("The code was copied."), tell);
  });
}
