/** Puts a text where the person can paste it. */
import { gettext } from "./text.ts";

/** Copy a text and tell `done`; where the browser does not let the page, tell the text itself. */
export async function copy(text: string, done: string, tell: (words: string) => void): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    tell(done);
  } catch {
    tell(gettext("Your browser did not let the page copy it: {text}", { text }));
  }
}
