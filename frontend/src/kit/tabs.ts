import { isRightToLeft } from "./dom.ts";

/** Tabs by the ARIA practices: arrow keys choose, and only the chosen tab is in the tab order. */
export class Tabs {
  open = "";
  private tabs: HTMLElement[];

  constructor(
    box: HTMLElement,
    private changed: (name: string) => void,
  ) {
    this.tabs = [...box.querySelectorAll<HTMLElement>('[role="tab"]')];
    this.open = nameOf(this.tabs[0]!);
    for (const tab of this.tabs) {
      tab.addEventListener("click", () => this.choose(nameOf(tab)));
      tab.addEventListener("keydown", (event) => this.key(event));
    }
  }

  choose(name: string, focus = false): void {
    if (name === this.open) return;
    this.open = name;
    for (const tab of this.tabs) {
      const chosen = nameOf(tab) === name;
      tab.setAttribute("aria-selected", String(chosen));
      tab.tabIndex = chosen ? 0 : -1;
      document.getElementById(tab.getAttribute("aria-controls") ?? "")!.hidden = !chosen;
      if (chosen && focus) tab.focus();
    }
    this.changed(name);
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return; // the browser's own, as Alt and an arrow
    const at = this.tabs.findIndex((tab) => nameOf(tab) === this.open);
    const right = isRightToLeft(this.tabs[0]!) ? -1 : 1; // the tab that lies to the right
    const to: Record<string, number> = { ArrowRight: at + right, ArrowLeft: at - right, Home: 0, End: this.tabs.length - 1 };
    const next = to[event.key];
    if (next === undefined) return;
    event.preventDefault();
    this.choose(nameOf(this.tabs[(next + this.tabs.length) % this.tabs.length]!), true);
  }
}

function nameOf(tab: HTMLElement): string {
  return tab.id.replace("tab-", "");
}
