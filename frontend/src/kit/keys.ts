/** The keys of a console's actions: what a person has chosen, in place of the defaults. A key is a character, not a place. */
import { gettext } from "./text.ts";

/** What a key does: its name, what it does in words, and its key at first; empty for an action that has none then. */
export interface KeyAction {
  name: string;
  use: string;
  key: string;
}
type Pressed = Pick<KeyboardEvent, "key" | "ctrlKey" | "metaKey" | "altKey">;

/** The action that stops the robot. These keys of it are nobody's to change; a person may add one. */
export const STOP = "stop";
const STOPS: ReadonlySet<string> = new Set(["escape", "s"]);
/** Keys that do the same everywhere, as people know them from other programs. */
const MOVES = gettext("move and choose"),
  FIXED: Readonly<Record<string, readonly [string, string]>> = {
    arrowup: ["↑", MOVES],
    arrowdown: ["↓", MOVES],
    arrowleft: ["←", MOVES],
    arrowright: ["→", MOVES],
    pageup: [gettext("Page up"), MOVES],
    pagedown: [gettext("Page down"), MOVES],
    home: [gettext("Home"), MOVES],
    end: [gettext("End"), MOVES],
    enter: [gettext("Enter"), gettext("press and send")],
    " ": [gettext("Space"), gettext("press and hold")],
  };
const LONGEST = 2000; // of what a browser has stored

/** Return the key of an event as the choice knows it; empty with Ctrl, Alt or ⌘, which make keys of the browser. */
export function keyOf({ key, ctrlKey, metaKey, altKey }: Pressed): string {
  return ctrlKey || metaKey || altKey ? "" : key.toLowerCase();
}

/** Return a key as the page shows it. */
export function keyInWords(key: string): string {
  const upper = key.toUpperCase();
  if (key === "-") return "−";
  return (Object.hasOwn(FIXED, key) && FIXED[key]?.[0]) || (upper.length === key.length ? upper : key);
}

/** Return the key that a page shows so. */
export function shownKey(words: string): string {
  return words === "−" ? "-" : words.toLowerCase();
}

export class KeyChoice {
  private chosen = new Map<string, string>(); // by action, where it is not the default
  private readonly actions: readonly KeyAction[];

  constructor(actions: readonly KeyAction[]) {
    this.actions = actions;
  }

  /** Return the key of an action; empty if it has none. */
  key(name: string): string {
    return this.chosen.get(name) ?? this.actions.find((one) => one.name === name)?.key ?? "";
  }

  /** Return the action of a key; empty if it has none. */
  action(key: string): string {
    if (STOPS.has(key)) return STOP;
    return (key && this.actions.find(({ name }) => this.key(name) === key)?.name) || "";
  }

  get isDefault(): boolean {
    return this.chosen.size === 0;
  }

  /** Return why that action cannot have the key; empty if it can. */
  whyNot(name: string, key: string): string {
    const shown = keyInWords(key),
      fixed = Object.hasOwn(FIXED, key) ? FIXED[key] : undefined;
    const taken = STOPS.has(key) ? STOP : this.action(key),
      use = fixed?.[1] ?? this.actions.find((one) => one.name === taken && one.name !== name)?.use ?? "";
    if (STOPS.has(key)) return gettext("{key} is a key of Stop, and stays one.", { key: shown });
    if (use) return gettext("{key} is in use: {use}. Choose another.", { key: shown, use });
    if (!isCharacter(key)) return gettext("Choose a letter, a digit or a sign.");
    return "";
  }

  /** Give a key to an action. Returns why it cannot have it; empty if it has it now. */
  choose(name: string, key: string): string {
    const why = this.whyNot(name, key);
    if (why) return why;
    if (this.actions.find((one) => one.name === name)?.key === key) this.chosen.delete(name);
    else this.chosen.set(name, key);
    return "";
  }

  reset(): void {
    this.chosen.clear();
  }

  /** Return what a browser stores. */
  get stored(): string {
    return JSON.stringify(Object.fromEntries(this.chosen));
  }

  /** Take what a browser has stored. A key that nobody could choose, or that two actions would have, is left out. */
  restore(stored: string | null): void {
    const wanted = readStored(stored),
      usable = (key: unknown): key is string =>
        typeof key === "string" && isCharacter(key) && !STOPS.has(key) && !Object.hasOwn(FIXED, key);
    this.chosen.clear();
    for (const { name, key } of this.actions) {
      const own = Object.hasOwn(wanted, name) ? wanted[name] : key;
      if (own !== key && usable(own)) this.chosen.set(name, own);
    }
    const doubled = (): string | undefined =>
      [...this.chosen.keys()].find((name) => this.actions.some((one) => one.name !== name && this.key(one.name) === this.key(name)));
    for (let name = doubled(); name !== undefined; name = doubled()) this.chosen.delete(name);
  }
}

function isCharacter(key: string): boolean {
  return Array.from(key).length === 1 && key.trim() !== "" && key === key.toLowerCase();
}

function readStored(stored: string | null): Record<string, unknown> {
  if (!stored || stored.length > LONGEST) return {};
  try {
    const read = JSON.parse(stored) as unknown;
    return typeof read === "object" && read !== null ? (read as Record<string, unknown>) : {};
  } catch {
    return {};
  }
}
