/** Names of people as pages show them. */
import { gettext } from "./text.ts";

/** What stands in place of a handle (`robots/people.py`); none of it can be anybody's. */
const OURS: ReadonlyMap<string, string> = new Map([
  ["Deleted account", gettext("Deleted account")],
  ["staff", gettext("staff")],
  ["somebody", gettext("somebody")],
]);

/** Return a handle as a page shows it: the words that stand in place of one are in the reader's language. */
export function shownName(handle: string): string {
  return OURS.get(handle) ?? handle;
}
