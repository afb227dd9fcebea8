/** Places as a list of buttons, so that the keyboard alone suffices to choose one. */
import { say } from "../kit/dom.ts";
import { allow, arrange } from "../kit/parts.ts";

export interface ListedSpot { letter: string; id: number; words: string }

export class SpotList {
  private items = new Map<string, { element: HTMLElement; button: HTMLElement; id: number }>();

  constructor(private box: HTMLElement, private onPick: (place: number) => void) {}

  /** Show these places; a button that stays keeps the focus. */
  show(spots: readonly ListedSpot[]): void {
    const shown = spots.map(({ letter, id, words }) => {
      const item = this.items.get(letter) ?? this.made(letter);
      item.id = id;
      say(item.button.lastElementChild!, words);
      return item.element;
    });
    for (const letter of [...this.items.keys()]) if (!spots.some((spot) => spot.letter === letter)) this.items.delete(letter);
    arrange(this.box, shown);
  }

  /** Enable the list, or disable it with a reason. */
  enable(why: string): void {
    for (const { button } of this.items.values()) allow(button, why);
  }

  private made(letter: string): { element: HTMLElement; button: HTMLElement; id: number } {
    const element = document.createElement("li"), button = document.createElement("button");
    const name = document.createElement("b"), words = document.createElement("span");
    name.textContent = letter;
    Object.assign(button, { type: "button", className: "button" });
    button.append(name, " ", words);
    element.append(button);
    const item = { element, button, id: 0 };
    button.addEventListener("click", () => this.onPick(item.id));
    this.items.set(letter, item);
    return item;
  }
}
