/** Moves the ghost without a pointer in the view: keys on its handle, and a button for each direction. */
import { isStale } from "../input/loop.ts";
import { byId, make, say, set } from "../kit/dom.ts";
import { gettext } from "../kit/text.ts";
import { facts } from "../page/facts.ts";
import { keys } from "../page/keys.ts";
import { isLarge, StepSize } from "../widgets/steps.ts";
import { keyMove, type Move, stepMove, STEPS, USUAL } from "./moves.ts";

export interface HandUse {
  /** Move the ghost by so much. */
  step(by: Move): void;
  home(): void;
  send(): void;
  /** Close (1) or open (0) the gripper of an arm that follows. */
  grip(closed: number): void;
  /** Say a sentence until the ghost is moved again. */
  note(text: string): void;
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

/** Return the steps of the ghost; a large one is a large part of where the tool may be sent. */
function steps(): StepSize<(typeof STEPS)[number] & { words: string; isLarge: boolean }> {
  const range = facts.commands.find(({ kind }) => kind === "pose")?.arguments.find(({ name }) => name === "x");
  const sizes = STEPS.map((step) => ({
    ...step,
    words: `${step.mm} mm, ${step.degrees}°`,
    isLarge: range !== undefined && isLarge(step.mm / 1000, range),
  }));
  return new StepSize(sizes, USUAL);
}

export class Hand {
  private pad = byId("ghost-pad");
  private handle = byId("ghost-handle");
  private select = byId<HTMLSelectElement>("ghost-step");
  private size = steps();
  private labels = WAYS.map(([sign, label, way]) => ({ sign, label, way, button: make("button", { type: "button", class: "button" }) }));

  constructor(private use: HandUse) {
    this.select.append(...STEPS.map(({ mm, degrees }, i) => make("option", { value: i }, `${mm} mm, ${degrees}°`)));
    this.select.addEventListener("change", () => this.choose(Number(this.select.value)));
    for (const { way, button } of this.labels) {
      button.addEventListener("click", () => this.move(way));
      this.pad.append(button);
    }
    byId("ghost-hand").addEventListener("keydown", (event) => this.key(event));
    this.choose(USUAL);
  }

  /** Another turn begins: the step has its usual size again. */
  reset(): void {
    this.size.reset();
    this.choose(this.size.index);
  }

  private choose(index: number): void {
    this.size.choose(index);
    const { mm, degrees } = this.size.now;
    this.select.value = String(this.size.index);
    for (const { sign, label, way, button } of this.labels) {
      const size = way.slice(3).some(Boolean) ? `${degrees}°` : `${mm} mm`;
      button.replaceChildren(`${sign} `, make("small", {}, size));
      set(button, { "aria-label": `${sign} ${size}: ${label}` });
    }
  }

  private move(way: Move): void {
    const asked = this.size.ask();
    if (asked) this.use.note(asked);
    else this.use.step(stepMove(way, this.size.now));
  }

  /** Let keys and a gamepad move the ghost. */
  focus(): void {
    this.handle.focus({ preventScroll: true });
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
    if (move) return () => this.move(move);
    if (key === "Enter" && target === this.handle) return () => !event.repeat && this.use.send();
    const acts: Record<string, () => void> = {
      longer: () => this.resize(1),
      shorter: () => this.resize(-1),
      "ghost-home": () => this.use.home(),
      close: () => this.use.grip(1),
      open: () => this.use.grip(0),
    };
    return acts[keys.action(event)] ?? null;
  }

  private resize(by: number): void {
    this.choose(this.size.index + by);
    say(byId("ghost-step-said"), gettext("Step {mm} mm, {degrees}°", { mm: this.size.now.mm, degrees: this.size.now.degrees }));
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
