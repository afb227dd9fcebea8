/** Whether somebody has filled in a target: fields without one show where the arm is. */

export class TargetEdit {
  private after = -1; // the number of the newest command at the last edit; -1: nothing is filled in

  get now(): boolean {
    return this.after >= 0;
  }

  /** Somebody has filled in something; `seq`: the number of the newest command. */
  note(seq: number): void {
    this.after = seq;
  }

  /** The command of that number has moved the arm: what was filled in before it is over. */
  arrived(seq: number): void {
    if (this.after < seq) this.after = -1;
  }

  forget(): void {
    this.after = -1;
  }
}
