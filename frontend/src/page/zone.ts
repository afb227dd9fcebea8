/** The reader's time zone: told to the server by a cookie, and used at once on the page on which it is new. */
import { language } from "../kit/text.ts";

const AGE_S = 31536000;
const DAY = { day: "numeric", month: "long", year: "numeric" } as const,
  MINUTE = { hour: "2-digit", minute: "2-digit", hourCycle: "h23" } as const,
  SECOND = { ...MINUTE, second: "2-digit" } as const;
const KINDS: Readonly<Record<string, readonly Intl.DateTimeFormatOptions[]>> = {
  day: [DAY],
  minute: [DAY, MINUTE],
  second: [DAY, SECOND],
  time: [SECOND],
};

/** Write the cookie if the zone is another one than before, and then the times of this page in it. */
export function tellZone(): void {
  const zone = Intl.DateTimeFormat().resolvedOptions().timeZone;
  if (!zone || document.cookie.split("; ").includes(`zone=${zone}`)) return;
  const secure = location.protocol === "https:" ? "; secure" : "";
  document.cookie = `zone=${zone}; path=/; max-age=${AGE_S}; samesite=lax${secure}`;
  for (const element of document.querySelectorAll<HTMLTimeElement>("time[data-moment]")) element.textContent = moment(element);
}

/** Return the time of an element in this browser's zone, as the server would write it. */
function moment(element: HTMLTimeElement): string {
  const parts = KINDS[element.dataset["moment"] ?? ""] ?? [DAY, MINUTE],
    locale = language() === "en" ? "en-GB" : language();
  return parts.map((options) => new Intl.DateTimeFormat(locale, options).format(new Date(element.dateTime))).join(", ");
}
