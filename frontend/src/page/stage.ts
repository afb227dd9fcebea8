/** The stage: which of its two views is shown, and how much of the window it and its bar take, for the styles. */
import { byId, say, set } from "../kit/dom.ts";
import { refusal } from "../kit/refusal.ts";
import { focusStage } from "../kit/stage_focus.ts";
import { storage } from "../kit/storage.ts";
import { gettext } from "../kit/text.ts";

const VIEWS = ["both", "beside", "picture"] as const; // in the order in which the button goes through them
type Shown = (typeof VIEWS)[number];
/** What the button shows; its name says more, beginning with the same word. */
const TEXTS: Record<Shown, string> = { both: gettext("Both"), beside: gettext("Enlarge"), picture: gettext("Picture") };

let pointed: HTMLElement | null = null;

/** Return why the control of the stage that has the focus, or that the pointer is on, is off; empty if it is not. */
export function pointedRefusal(): string {
  // who reads the whole line points at the line itself
  if (document.activeElement?.id !== "why") pointed = document.querySelector('#stage [aria-disabled="true"]:is(:hover, :focus)');
  return pointed ? refusal(pointed) : "";
}

export class Stage {
  private view = byId("stage-view");
  private bar = byId("stage-bar");
  private keep = byId("stage-keep");
  private release = byId("release");
  private button = document.getElementById("view-switch");
  private names: Record<Shown, string>;
  private stored: string;

  constructor(slug: string) {
    this.stored = `views-${slug}`;
    const alone = document.querySelector<HTMLElement>(".stage-beside [data-alone]")?.dataset["alone"];
    this.names = { both: gettext("Both views"), beside: alone ?? TEXTS.beside, picture: gettext("Picture alone") };
    const { button } = this;
    if (button) {
      button.hidden = false;
      button.addEventListener("click", () => this.show(this.next(), true));
    }
    this.show(VIEWS.find((one) => one === storage.get(this.stored)) ?? "both");
    const sizes = new ResizeObserver(() => this.measure());
    for (const box of [this.bar, this.keep, this.view, this.release, document.body]) sizes.observe(box);
    addEventListener("resize", () => this.measure());
  }

  /** Tell the styles how high the bar, the release above it and the part that stays are, and where the stage begins on a page that is not scrolled (px). Not called at each drawing: it forces a layout. */
  private measure(): void {
    const high = getComputedStyle(this.bar).position === "fixed" ? this.bar.offsetHeight : 0;
    const top = byId("stage").parentElement?.getBoundingClientRect().top ?? 0;
    this.write("--stage-bar", high);
    this.write("--stage-keep", this.keep.offsetHeight || this.view.offsetHeight);
    this.write("--release", this.release.offsetHeight);
    this.write("--stage-top", top + scrollY);
  }

  private write(name: string, pixels: number): void {
    const { style } = document.documentElement,
      is = `${Math.round(pixels)}px`;
    if (style.getPropertyValue(name) !== is) style.setProperty(name, is);
  }

  private next(): Shown {
    const is = VIEWS.findIndex((one) => one === this.view.dataset["shown"]);
    return VIEWS[(is + 1) % VIEWS.length] ?? "both";
  }

  private show(what: Shown, chosen = false): void {
    const was = this.view.contains(document.activeElement) && document.activeElement !== this.button;
    set(this.view, { "data-shown": this.button ? what : "both" });
    if (this.button) {
      say(this.button, TEXTS[this.next()]);
      set(this.button, { "aria-label": this.names[this.next()], title: this.names[this.next()] });
    }
    if (chosen) storage.set(this.stored, what);
    if (was && !document.activeElement?.checkVisibility()) focusStage();
  }
}
