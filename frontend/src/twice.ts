/** What cannot be taken back is asked about: the same button, in the same place, is pressed once more. */

const ASKED_MS = 8000; // how long the question stands
const DOUBLE_MS = 400; // a double click is one press

export class Twice {
  private asked = -Infinity;

  /** Tell whether the question stands. */
  get asking(): boolean {
    return performance.now() - this.asked < ASKED_MS;
  }

  /** A press; tells whether it is the second, which is meant. */
  press(): boolean {
    const since = performance.now() - this.asked;
    if (since < DOUBLE_MS) return false;
    const sure = since < ASKED_MS;
    this.asked = sure ? -Infinity : performance.now();
    return sure;
  }
}
