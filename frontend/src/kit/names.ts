/** Names of people as pages show them. */
import { gettext } from "./text.ts";

/** What stands in place of a handle (`robots/people.py`); neither can be anybody's. */
const OURS: ReadonlyMap<string, string> = new Map([
  ["Deleted account", gettext("Deleted account")],
  ["staff", gettext("staff")],
]);

/** Return a handle as a page shows it: staff, and who has deleted the account, are named in the reader's language. */
export function shownName(handle: string): string {
  return OURS.get(handle) ?? handle;
}
