/** The stages of a command in words. */
import type { CommandInfo } from "./messages.ts";
import { gettext } from "../kit/text.ts";

export const STAGES: Record<string, string> = {
  sending: gettext("Sending"),
  queued: gettext("Queued"),
  accepted: gettext("Accepted"),
  sent: gettext("Sent to the robot"),
  acknowledged: gettext("Moving"),
  completed: gettext("Done"),
  rejected: gettext("Refused"),
  failed: gettext("Failed"),
  expired: gettext("Too late"),
  cancelled: gettext("Stopped"),
  unknown: gettext("Unknown"),
};
/** The labels of commands, and the kinds that set something and move nothing; the robot's page fills both. */
export const COMMAND_LABELS: Record<string, string> = {};
export const SETTING_KINDS = new Set<string>();
/** Return the stage of a command in words. */
export function stageOf(kind: string, state: string): string {
  if (SETTING_KINDS.has(kind) && state === "acknowledged") return gettext("Under way");
  return STAGES[state] ?? state;
}
export const FINAL = new Set(["completed", "rejected", "failed", "expired", "cancelled", "unknown"]);

/** Return the later one of what is known of a command and what a snapshot contains, which may be older. */
export function laterStage(known: CommandInfo | undefined, read: CommandInfo): CommandInfo {
  if (!known || known.id !== read.id || FINAL.has(read.state)) return read;
  return FINAL.has(known.state) || known.at_ms > read.at_ms ? known : read;
}
