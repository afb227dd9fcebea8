/** What the gripper holds, in words, from what its hardware tells. */

/** The table `gripper` of a robot's description: joint of the state that tells the opening, and its widths (m). */
export interface GripperFacts {
  joint?: string;
  open: number;
  empty_below?: number;
}
const WIDE_M = 0.002; // fingers within this of their full opening hold nothing (robots/kit/arms/hand.py),
const STILL_M = 0.0005; // and those that have moved by less since the state before rest

export type Grip = "open" | "empty" | "holds" | "moving" | "unknown";

/** Return what fingers of that opening (m) say, which was `before` in the state before; NaN where it is not known. */
export function gripOf({ open, empty_below }: GripperFacts, opening: number, before: number): Grip {
  if (empty_below === undefined || !Number.isFinite(opening)) return "unknown";
  if (Math.abs(opening - before) > STILL_M) return "moving";
  if (opening >= open - WIDE_M) return "open";
  return opening < empty_below ? "empty" : "holds";
}

/** Return it as a sentence; `held`: the name of the object that the robot knows there. */
export function gripInWords(grip: Grip, held: string): string {
  if (grip === "moving") return "The gripper moves.";
  if (held) return grip === "unknown" ? `The gripper should hold ${held}; it cannot feel.` : `The gripper holds ${held}.`;
  return SENTENCES[grip];
}

const SENTENCES = {
  holds: "The gripper holds something.",
  empty: "The gripper is empty.",
  open: "The gripper is open and empty.",
  unknown: "The gripper cannot feel whether it holds something.",
};

/** Return it in the fewest words, for the picture's edge. */
export function gripInShort(grip: Grip, held: string): string {
  if (grip === "moving") return "Gripper moves";
  if (held) return `Holds ${held}`;
  return { holds: "Holds something", empty: "Empty", open: "Empty, open", unknown: "" }[grip];
}
