/** Confirmation of actions that cannot be undone: the same button, in the same place, is pressed again. */

const ASKED_MS = 8000; // how long the question is shown
const DOUBLE_MS = 400; // a double click is one press

export class Confirmation {
  private asked = -Infinity;

  /** Whether the question is shown. */
  get asking(): boolean {
    return performance.now() - this.asked < ASKED_MS;
  }

  /** Take a press. Returns whether it is the second one, which confirms. */
  press(): boolean {
    const since = performance.now() - this.asked;
    if (since < DOUBLE_MS) return false;
    const sure = since < ASKED_MS;
    this.asked = sure ? -Infinity : performance.now();
    return sure;
  }
}
