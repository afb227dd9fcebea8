/** The list of keys, where each can be changed: it moves nothing, all keys work while it is open, and it closes for the release of a stop. */
import { byId, make, say, set } from "../kit/dom.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { gettext } from "../kit/text.ts";
import type { KeyAction } from "../kit/keys.ts";
import { keys } from "./keys.ts";

const MODIFIERS = new Set(["Shift", "Control", "Alt", "AltGraph", "Meta", "CapsLock"]);
const card = byId<HTMLDialogElement>("keys");
const opener = byId("keys-open");

function toggle(): void {
  if (card.open) card.close();
  else card.show();
}

opener.addEventListener("click", toggle);
opener.setAttribute("aria-expanded", "false");
new MutationObserver(() => opener.setAttribute("aria-expanded", String(card.open))).observe(card, { attributeFilter: ["open"] });
new MutationObserver(() => byId("release").hidden || card.close()).observe(byId("release"), { attributeFilter: ["hidden"] });
byId("stage").addEventListener("keydown", (event) => {
  const field = (event.target as HTMLElement).closest("input, textarea, select, [contenteditable]");
  if (field || keys.action(event) !== "keys") return;
  event.preventDefault();
  toggle();
});
card.addEventListener("keydown", (event) => {
  if (event.key !== "Escape") return;
  event.stopPropagation(); // it closes the list and must not stop the robot
  card.close();
});

/** The button beside a key, which waits for another one after a press. */
class Change {
  private button = make("button", { type: "button", class: "linklike" });
  private waits = false;

  constructor(
    private action: KeyAction,
    private tell: (words: string) => void,
  ) {
    const { button } = this;
    button.addEventListener("click", () => this.wait(!this.waits));
    button.addEventListener("keydown", (event) => this.waits && this.key(event));
    button.addEventListener("keyup", (event) => this.waits && event.preventDefault()); // the space bar presses as it goes up
    button.addEventListener("focusout", () => this.waits && this.wait(false));
    card.addEventListener("close", () => this.waits && this.wait(false));
    card.querySelector(`kbd[data-action="${action.name}"]`)?.closest("dt")?.nextElementSibling?.append(" ", button);
  }

  draw(): void {
    const { use, name } = this.action,
      key = keys.shown(name) || gettext("no key yet");
    const word = this.waits ? gettext("Press a key") : name === "stop" ? gettext("Choose one more") : gettext("Change");
    say(this.button, word);
    set(this.button, { "aria-label": `${word}: ${use} (${key})`, "data-waits": String(this.waits) });
  }

  private wait(waits: boolean): void {
    this.waits = waits;
    if (waits) this.button.focus(); // not every browser gives it to a button that is clicked
    this.tell(
      waits
        ? gettext("Press the new key for: {use}. Escape leaves the old one.", { use: this.action.use })
        : gettext("The keys stay as they were."),
    );
    this.draw();
  }

  private key(event: KeyboardEvent): void {
    if (event.key === "Tab" || MODIFIERS.has(event.key)) return; // Tab leaves, a modifier is half a key
    event.preventDefault();
    event.stopPropagation(); // it is chosen, and does nothing yet
    if (event.repeat) return;
    if (event.key === "Escape") return this.wait(false);
    const why =
      event.ctrlKey || event.metaKey || event.altKey
        ? gettext("Keys with Ctrl, Alt or ⌘ are the browser's.")
        : keys.choose(this.action.name, event);
    if (why) return this.tell(why);
    this.waits = false;
    this.tell(gettext("{key} is the key now for: {use}.", { key: keys.shown(this.action.name), use: this.action.use }));
    this.draw();
  }
}

function offerChanges(): void {
  const said = make("p", { role: "status", class: "keys-said" }),
    reset = make("button", { type: "button", class: "button" }, gettext("Reset all keys"));
  const tell = (words: string): void => say(said, words);
  const changes = keys.actions.map((action) => new Change(action, tell));
  const draw = (): void => {
    for (const change of changes) change.draw();
    allow(reset, keys.isDefault ? gettext("All keys are as at first.") : "");
  };
  reset.addEventListener("click", () => {
    if (!refusal(reset)) keys.reset();
    tell(gettext("All keys are as at first."));
  });
  document.addEventListener("farhand:keys", draw);
  card.append(said, make("p", { class: "row" }, reset));
  draw();
}

if (keys.actions.length) offerChanges();
