/** The ghost of the tool: it is at the arm until somebody moves it, and stays where the arm could rest. */
import type { Pose } from "../motion/chain.ts";
import type { Judgement } from "./judge.ts";
import { distance, type Move, moved } from "./moves.ts";

const HERE_M = 0.0002,
  HERE_RAD = 0.0005; // so near it is at the arm

/** Returns the pose to which one snaps, or itself. `from`: where a step begins; one that leaves does not snap back. */
type Snap = (pose: Float64Array, from: Pose | null) => Float64Array;
/** Returns how far one comes from a pose to one that is refused. */
type Along = (from: Pose, to: Pose) => Float64Array;

export class Ghost {
  private own: Float64Array | null = null; // where somebody has put it; null: at the arm
  private arm: Pose | null = null;
  private hand: { pose: Float64Array } | null = null; // where it was when the hand took it
  private standing: Judgement | null = null;
  /** Whether it has snapped to a grasp or a place. */
  snapped = false;
  /** Why the last move was refused; empty if it was not. */
  refusal = "";
  private readonly judge: (pose: Pose) => Judgement;
  private readonly snap: Snap;
  private readonly along: Along | null;

  /** `along`: how a ghost that is dragged against a surface slides on; without it it stays where it is. */
  constructor(judge: (pose: Pose) => Judgement, snap: Snap = (pose) => pose, along: Along | null = null) {
    [this.judge, this.snap, this.along] = [judge, snap, along];
  }

  /** Where it is; null while the arm's place is not known. */
  get pose(): Pose | null {
    return this.own ?? this.arm;
  }

  /** Whether somebody has put it elsewhere than at the arm. */
  get away(): boolean {
    if (!this.own) return false;
    const far = this.arm && distance(this.arm, this.own);
    return !far || far.m > HERE_M || far.rad > HERE_RAD;
  }

  /** What would happen at its pose; null if nothing is known, or it is at the arm. */
  get judgement(): Judgement | null {
    return this.standing;
  }

  get isHeld(): boolean {
    return this.hand !== null;
  }

  /** Take over where the arm's tool is. A ghost that is held or was put somewhere stays. */
  follow(arm: Pose | null): void {
    this.arm = arm;
  }

  /** A hand takes it: what follows is measured from here, so it does not leap. */
  take(): void {
    const { pose } = this;
    this.refusal = "";
    this.hand = pose && { pose: Float64Array.from({ length: 16 }, (_, i) => pose[i] ?? 0) };
  }

  /** Move it, by so much since it was taken. Nothing happens unless it is held. */
  drag(by: Move): void {
    if (!this.hand) return;
    const wanted = moved(this.hand.pose, by);
    if (!this.place(wanted, null)) this.slide(wanted);
  }

  /** Move it on by so much, also while nobody holds it; against a surface it slides. */
  nudge(by: Move): void {
    const { pose } = this;
    if (!pose) return;
    const wanted = moved(pose, by);
    if (!this.place(wanted, pose)) this.slide(wanted);
  }

  /** Go as near to a refused pose as surfaces allow. */
  private slide(wanted: Float64Array): void {
    const { pose, refusal } = this;
    if (!pose || !this.along) return;
    this.put(this.along(pose, wanted));
    this.refusal = refusal; // of what the hand wants, though the ghost has moved
  }

  /** The hand lets go. The ghost stays where it is. */
  release(): void {
    this.hand = null;
    this.refusal = "";
  }

  /** Move it by so much. Returns whether it went there. */
  step(by: Move): boolean {
    return this.pose !== null && this.place(moved(this.pose, by), this.pose);
  }

  private place(wanted: Float64Array, from: Pose | null): boolean {
    const to = this.snap(wanted, from),
      isThere = this.put(to);
    this.snapped = isThere && to !== wanted;
    return isThere;
  }

  /** Put it there; if the arm cannot be there it stays where it was. Returns whether it is there. */
  put(pose: Float64Array): boolean {
    const found = this.judge(pose);
    this.refusal = found.verdict === "refused" ? found.text : "";
    this.snapped = false;
    if (this.refusal) return false;
    this.own = pose;
    this.standing = found;
    return true;
  }

  /** Move it exactly to the goal at which the words say it is, if the arm can come there. */
  moveToGoal(goal: (pose: Float64Array) => Float64Array): void {
    const { own } = this,
      to = own && goal(own),
      found = to && to !== own && distance(own, to).m + distance(own, to).rad > 0 ? this.judge(to) : null;
    if (found?.verdict === "free") [this.own, this.standing, this.snapped] = [to, found, true];
  }

  /** Judge its place again: the arm has moved, or the speed is another. It stays, whatever comes of that. */
  again(): void {
    this.standing = this.own && this.judge(this.own);
  }

  /** Take it back to the arm. A hand that holds it has to take it again. */
  home(): void {
    this.own = this.standing = this.hand = null;
    this.snapped = false;
    this.refusal = "";
  }
}
