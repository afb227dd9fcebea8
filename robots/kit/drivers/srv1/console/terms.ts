/** Plain words for the terms of the paper's rules (Tables 1 and 2). */
import { gettext } from "/static/farhand/v1/text.js";

const MIDDLE = gettext("medium");
const AWAY = { VN: gettext("very near"), N: gettext("near"), M: MIDDLE, F: gettext("far"), VF: gettext("very far") };
const LEVELS = { VN: gettext("very low"), N: gettext("low"), M: MIDDLE, F: gettext("high"), VF: gettext("very high") };
const SPEEDS = { VS: gettext("very slow"), S: gettext("slow"), M: MIDDLE, F: gettext("fast"), VF: gettext("very fast") };
const WORDS: Readonly<Record<string, Readonly<Record<string, string>>>> = { infrared: AWAY, sonar: AWAY, speed: SPEEDS };

/** Return the plain word for a term of that reading or of the speed; empty for a term of somebody's own. */
export function plainTerm(reading: string, term: string): string {
  return Object.entries(WORDS[reading] ?? LEVELS).find(([name]) => name === term)?.[1] ?? "";
}
