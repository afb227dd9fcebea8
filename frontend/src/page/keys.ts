/** The keys of this page's actions, which its list of keys declares (`data-action`), as the person has chosen them. */
import { byId, say } from "../kit/dom.ts";
import { storage } from "../kit/storage.ts";
import { type KeyAction, KeyChoice, keyInWords, keyOf, shownKey } from "../kit/keys.ts";

const card = byId("keys");
const NAMED = "kbd[data-action]";

function declared(): KeyAction[] {
  return [...card.querySelectorAll<HTMLElement>(NAMED)].map((one) => ({
    name: one.dataset["action"] ?? "",
    use: useOf(one),
    key: shownKey(one.textContent.trim()),
  }));
}

/** Return what the key does: the words beside it in the list. */
function useOf(one: HTMLElement): string {
  const words = one.closest("dt")?.nextElementSibling;
  return words?.textContent.trim() ?? "";
}

class Keys {
  readonly actions = declared();
  private choice = new KeyChoice(this.actions);
  private stored = `keys-${byId("stage").dataset["driver"] ?? ""}`; // one choice for each kind of robot: no key is another's there

  constructor() {
    this.read();
    addEventListener("storage", () => this.read()); // another page of this person
  }

  private read(): void {
    this.choice.restore(storage.get(this.stored));
    this.draw();
  }

  /** Return the action of a key that is pressed; empty if it has none, and with Ctrl, Alt or ⌘. */
  action(event: KeyboardEvent): string {
    return this.choice.action(keyOf(event));
  }

  get isDefault(): boolean {
    return this.choice.isDefault;
  }

  /** Return the key of an action as the page shows it; empty if it has none. */
  shown(name: string): string {
    return keyInWords(this.choice.key(name));
  }

  /** Give the pressed key to an action, and keep that. Returns why it cannot have it; empty if it has it now. */
  choose(name: string, event: KeyboardEvent): string {
    const why = this.choice.choose(name, keyOf(event));
    if (!why) this.keep();
    return why;
  }

  /** Give all actions their first keys. */
  reset(): void {
    this.choice.reset();
    this.keep();
  }

  private keep(): void {
    storage.set(this.stored, this.choice.stored);
    this.draw();
  }

  /** Write the keys wherever the page names them. */
  private draw(): void {
    for (const one of document.querySelectorAll<HTMLElement>(NAMED)) {
      const key = this.shown(one.dataset["action"] ?? "");
      one.hidden = !key;
      say(one, key);
    }
    document.dispatchEvent(new Event("farhand:keys"));
  }
}

export const keys = new Keys();
