/** Moves the ghost without a pointer in the view: keys on its handle, and a button for each direction. */
import { isStale } from "../input/loop.ts";
import { byId, make, say } from "../kit/dom.ts";
import { gettext } from "../kit/text.ts";
import { keyMove, type Move, type Step, stepMove, STEPS } from "./moves.ts";

export interface HandUse {
  /** Move the ghost by so much. */
  step(by: Move): void;
  home(): void;
  send(): void;
  /** Close (1) or open (0) the gripper of an arm that follows. */
  grip(closed: number): void;
}

const WAYS: readonly (readonly [string, string, Move])[] = [
  ["x +", gettext("Ghost away from the base"), [1, 0, 0, 0, 0, 0]],
  ["x −", gettext("Ghost towards the base"), [-1, 0, 0, 0, 0, 0]],
  ["y +", gettext("Ghost to the left"), [0, 1, 0, 0, 0, 0]],
  ["y −", gettext("Ghost to the right"), [0, -1, 0, 0, 0, 0]],
  ["z +", gettext("Ghost up"), [0, 0, 1, 0, 0, 0]],
  ["z −", gettext("Ghost down"), [0, 0, -1, 0, 0, 0]],
  ["↻ x", gettext("Turn the ghost about x"), [0, 0, 0, 1, 0, 0]],
  ["↺ x", gettext("Turn the ghost back about x"), [0, 0, 0, -1, 0, 0]],
  ["↻ y", gettext("Turn the ghost about y"), [0, 0, 0, 0, 1, 0]],
  ["↺ y", gettext("Turn the ghost back about y"), [0, 0, 0, 0, -1, 0]],
  ["↻ z", gettext("Turn the ghost about z"), [0, 0, 0, 0, 0, 1]],
  ["↺ z", gettext("Turn the ghost back about z"), [0, 0, 0, 0, 0, -1]],
];

export class Hand {
  private pad = byId("ghost-pad");
  private handle = byId("ghost-handle");
  private size = byId<HTMLSelectElement>("ghost-step");

  constructor(private use: HandUse) {
    this.size.append(...STEPS.map(({ mm, degrees }, i) => make("option", { value: i }, `${mm} mm, ${degrees}°`)));
    this.size.value = "1";
    for (const [sign, label, way] of WAYS) {
      const button = make("button", { type: "button", class: "button", "aria-label": `${sign}: ${label}` }, sign);
      button.addEventListener("click", () => use.step(stepMove(way, this.step)));
      this.pad.append(button);
    }
    byId("ghost-hand").addEventListener("keydown", (event) => this.key(event));
  }

  /** Let keys and a gamepad move the ghost. */
  focus(): void {
    this.handle.focus({ preventScroll: true });
  }

  private get step(): Step {
    return STEPS[Number(this.size.value)]!;
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const act = this.action(event);
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    if (!isStale(event, performance.now())) act();
  }

  private action(event: KeyboardEvent): (() => void) | null {
    const { key, shiftKey, target } = event;
    const move = keyMove(key, shiftKey);
    if (move) return () => this.use.step(stepMove(move, this.step));
    if (key === "+" || key === "-") return () => this.resize(key === "+" ? 1 : -1);
    const letter = key.toLowerCase();
    if (letter === "g") return () => this.use.home();
    if (letter === "c" || letter === "o") return () => this.use.grip(letter === "c" ? 1 : 0);
    if (key === "Enter" && target === this.handle) return () => !event.repeat && this.use.send();
    return null;
  }

  private resize(by: number): void {
    this.size.value = String(Math.max(0, Math.min(STEPS.length - 1, Number(this.size.value) + by)));
    say(byId("ghost-step-said"), gettext("Step {mm} mm, {degrees}°", { mm: this.step.mm, degrees: this.step.degrees }));
  }

  /** Whether the handle, its buttons or the view has the focus, so that what has no place on the page may move the ghost. */
  get isHere(): boolean {
    return document.hasFocus() && byId("ghost-hand").contains(document.activeElement);
  }
}

/** Return a button with these words. */
export function viewButton(name: string, act: () => void): HTMLElement {
  const button = make("button", { type: "button", class: "button" }, name);
  button.addEventListener("click", act);
  return button;
}
