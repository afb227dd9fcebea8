/** Where the running command takes the robot, for people who watch: a sentence over the view, and a place for consoles. */
import type { CommandInfo, Target } from "../socket/messages.ts";
import { FINAL } from "../socket/stages.ts";

/** Return the target of the newest command that has not ended; null if none has a target. */
export function targetOf(commands: readonly CommandInfo[]): (Target & { id: number }) | null {
  const running = commands.filter((c) => c.target?.words && !FINAL.has(c.state)).sort((a, b) => b.id - a.id)[0];
  return running?.target ? { ...running.target, id: running.id } : null;
}
