/** The reader's time zone: told to the server by a cookie, and used at once on the page on which it is new. */
import { language } from "../kit/text.ts";

const AGE_S = 31536000;
const KINDS: Readonly<Record<string, Intl.DateTimeFormatOptions>> = {
  day: { day: "numeric", month: "long", year: "numeric" },
  minute: { day: "numeric", month: "long", year: "numeric", hour: "2-digit", minute: "2-digit" },
  second: { day: "numeric", month: "long", year: "numeric", hour: "2-digit", minute: "2-digit", second: "2-digit" },
  time: { hour: "2-digit", minute: "2-digit", second: "2-digit" },
};

/** Write the cookie if the zone is another one than before, and then the times of this page in it. */
export function tellZone(): void {
  const zone = Intl.DateTimeFormat().resolvedOptions().timeZone;
  if (!zone || document.cookie.split("; ").includes(`zone=${zone}`)) return;
  const secure = location.protocol === "https:" ? "; secure" : "";
  document.cookie = `zone=${zone}; path=/; max-age=${AGE_S}; samesite=lax${secure}`;
  for (const element of document.querySelectorAll<HTMLTimeElement>("time[data-moment]")) element.textContent = moment(element);
}

/** Return the time of an element in this browser's zone. */
function moment(element: HTMLTimeElement): string {
  const options = KINDS[element.dataset["moment"] ?? ""] ?? KINDS["minute"];
  const at = new Date(element.dateTime);
  return new Intl.DateTimeFormat(language(), { ...options, hourCycle: "h23" }).format(at);
}
