/** The rules for the controls of the arm over sand: enabled, or disabled with a reason. */
import type { Facts } from "/static/farhand/v1/console.js";
import { gettext } from "/static/farhand/v1/text.js";

/** `blocked`: why nothing at all can be commanded. */
export interface SandFacts extends Facts {
  blocked: string;
  aim: "none" | "good" | "refused" | "old";
}

const DOWN_M = 0.001;

/** Why a control does not work now; empty if it does. */
export function whyNot(kind: string, f: SandFacts): string {
  if (f.blocked) return f.blocked;
  if (f.busy) return gettext("One command at a time: the arm is still busy.");
  const z = f.state?.joints[2] ?? 0;
  if (kind === "air" && z > DOWN_M) return gettext("Air works only while the arm is down: press Down first.");
  if (kind === "down" && z <= DOWN_M) return gettext("The arm is down already.");
  if (kind === "up" && z >= 0.0745) return gettext("The arm is up already.");
  if (kind === "go" && f.aim === "none") return gettext("Click in the camera image or in the map to choose where to go.");
  if (kind === "go" && f.aim === "refused") return gettext("The arm may not go there: it is off the sand.");
  if (kind === "go" && f.aim === "old") return gettext("The arm has moved since that picture; click in the newest one.");
  return "";
}
