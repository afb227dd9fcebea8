/** Places as a list of buttons, so that the keyboard alone suffices to choose one. */
import { html } from "lit-html";
import { allowed, drawParts, type Part } from "../kit/render.ts";

export interface ListedSpot {
  letter: string;
  id: number;
  words: string;
}

export class SpotList {
  private spots: readonly ListedSpot[] = [];
  private why = "";

  constructor(
    private box: HTMLElement,
    private onPick: (place: number) => void,
  ) {}

  /** Show these places; a button that stays keeps the focus. */
  show(spots: readonly ListedSpot[]): void {
    this.spots = spots;
    this.draw();
  }

  /** Enable the list, or disable it with a reason. */
  enable(why: string): void {
    this.why = why;
    this.draw();
  }

  private draw(): void {
    const item = ({ letter, id, words }: ListedSpot): Part => ({
      key: letter,
      template: html`<li><button type="button" class="button" @click=${() => this.onPick(id)} ${allowed(this.why)}><b>${letter}</b> <span>${words}</span></button></li>`,
    });
    drawParts(this.box, this.spots.map(item));
  }
}
