/** What the page is told of its robot: the spec's commands and names, and what its description adds. */
import type { RobotFacts } from "./protocol.ts";
import { byId } from "./svg.ts";

export const facts = JSON.parse(byId("description").textContent ?? "{}") as RobotFacts;
/** The kinds of commands that set something: they run beside a motion, in a lane of their own. */
export const settings: ReadonlySet<string> = new Set(facts.commands.filter((c) => c.lane === "config").map((c) => c.kind));
