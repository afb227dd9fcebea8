/** Places without a pointer: fields for coordinates, and the last places of the turn as buttons. */
import { html } from "lit-html";
import { make, set } from "../kit/dom.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { allowed, drawParts, type Part } from "../kit/render.ts";
import { gettext } from "../kit/text.ts";
import type { CommandInfo } from "../socket/messages.ts";
import { placesAfter } from "./place_rules.ts";

/** A coordinate of a place: its name, its range (SI units), and the unit of its field, of which `per` make the SI unit. */
export interface Coordinate {
  name: string;
  unit: string;
  per: number;
  low: number;
  high: number;
}
type Place = readonly number[];

export class PlaceForm {
  private inputs: HTMLInputElement[];
  private button = make("button", { class: "button" }, gettext("Choose this place"));

  /** `onPick` gets the coordinates in SI units; what lies out of range is refused as a click there would be. */
  constructor(
    form: HTMLFormElement,
    coordinates: readonly Coordinate[],
    onPick: (place: number[]) => void,
    private refuse: (why: () => string) => void,
  ) {
    set(form, { novalidate: "" });
    this.inputs = coordinates.map(({ low, high, per }) =>
      make("input", {
        type: "number",
        step: "any",
        placeholder: gettext("{low} to {high}", { low: round(low * per), high: round(high * per) }),
      }),
    );
    form.append(...coordinates.map(({ name, unit }, i) => make("label", {}, `${name} (${unit}) `, this.inputs[i]!)), this.button);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (this.whyNot()) this.refuse(() => this.whyNot());
      else onPick(this.inputs.map((input, i) => input.valueAsNumber / coordinates[i]!.per));
    });
  }

  private whyNot(): string {
    const empty = this.inputs.some((input) => !Number.isFinite(input.valueAsNumber));
    return refusal(this.button) || (empty ? gettext("Fill in every value with a number first.") : "");
  }

  /** Enable the form, or disable it with a reason. */
  enable(why: string): void {
    allow(this.button, why);
  }
}

export class RecentPlaces {
  private places: readonly Place[] = [];
  private known = new Set<number>();
  private why = "";

  /** `names`: the coordinates of a command's place; `words`: a place in words. */
  constructor(
    private box: HTMLElement,
    private names: readonly string[],
    private words: (place: Place) => string,
    private onPick: (place: Place) => void,
  ) {}

  /** Note where a command of this turn takes the robot. */
  take({ id, target }: CommandInfo): void {
    const place = this.names.map((name) => target?.place?.[name] ?? NaN);
    if (this.known.has(id) || !place.every(Number.isFinite)) return;
    this.known.add(id);
    this.places = placesAfter(this.places, place);
    this.draw();
  }

  /** Forget all: another turn has begun. */
  forget(): void {
    this.places = [];
    this.draw();
  }

  /** Enable the places, or disable them with a reason. */
  enable(why: string): void {
    if (why === this.why) return;
    this.why = why;
    this.draw();
  }

  private draw(): void {
    const item = (place: Place): Part => ({
      key: place.join(" "),
      template: html`<li><button type="button" class="button" @click=${() => this.onPick(place)} ${allowed(this.why)}>${this.words(place)}</button></li>`,
    });
    drawParts(this.box, this.places.map(item));
  }
}

function round(value: number): number {
  return Math.round(value * 10) / 10;
}
