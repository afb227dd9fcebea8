/** What the gripper holds, in words, from what its hardware tells. */
import { gettext, translate } from "../kit/text.ts";

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

/** Tell whether something is to be put down: what the fingers tell, else whether the robot believes `held` there. */
export function isLoaded(grip: Grip, held: string): boolean {
  return grip === "holds" || (held !== "" && (grip === "unknown" || grip === "moving"));
}

/** Return it as a sentence; `held`: the name of the object that the robot believes there, which fingers may contradict. */
export function gripInWords(grip: Grip, held: string): string {
  if (grip === "moving") return gettext("The gripper moves.");
  const object = translate(held);
  if (held && grip === "unknown") return gettext("The gripper should hold {object}; it cannot feel.", { object });
  if (held && grip === "holds") return gettext("The gripper holds {object}.", { object });
  if (held) return gettext("The gripper is empty: it feels nothing, {object} was expected.", { object });
  return SENTENCES[grip];
}

const SENTENCES = {
  holds: gettext("The gripper holds something."),
  empty: gettext("The gripper is empty."),
  open: gettext("The gripper is open and empty."),
  unknown: gettext("The gripper cannot feel whether it holds something."),
};

/** Return it in the fewest words, for the picture's edge. */
export function gripInShort(grip: Grip, held: string): string {
  if (grip === "moving") return gettext("Gripper moves");
  const object = translate(held);
  if (held && grip === "unknown") return gettext("Should hold {object}", { object });
  if (held && grip === "holds") return gettext("Holds {object}", { object });
  if (held) return gettext("Empty, {object} expected", { object });
  return { holds: gettext("Holds something"), empty: gettext("Empty"), open: gettext("Empty, open"), unknown: "" }[grip];
}
