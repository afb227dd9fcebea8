/** What the page knows about its robot: commands and names of the spec, and its description. */
import { byId } from "../kit/dom.ts";
import type { RobotFacts } from "../socket/messages.ts";

export const facts = JSON.parse(byId("description").textContent) as RobotFacts;
/** The kinds of commands that change a setting; they run beside a motion, in the lane `config`. */
export const configKinds: ReadonlySet<string> = new Set(facts.commands.filter((c) => c.lane === "config").map((c) => c.kind));
