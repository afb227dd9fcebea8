/** The admin's first page: cards of robots with live pictures, and what waits for staff, without a reload. */
import "./first_page.css";
import { byId, say } from "../kit/dom.ts";
import { morph } from "../kit/morph.ts";
import { every } from "../kit/page_clock.ts";
import { request } from "../kit/request.ts";
import { gettext } from "../kit/text.ts";
import { LiveCard, offerPause } from "../page/live_card.ts";

const SELDOM_MS = 10_000; // for what no robot tells: incidents, entries, programs
const SOON_MS = 1000, // the least time between two looks
  READ_MS = 8000; // how long it is said that nothing was confirmed, at least
const UNANSWERED = gettext(
  "The portal has not confirmed that, so it is not known whether it was done. Press again; in an emergency use the stop at the robot.",
);
const OLD = gettext("This page is not live: the portal is not reached. It goes on by itself.");

const live = byId("live"),
  line = byId("not-live"),
  cards = new Map<string, LiveCard>();
let looking = false,
  wanted = false, // something has changed since the last look began
  until = 0; // no look replaces or hides what is said before

/** Put what came into the page; pictures, open parts and what is written stay. */
function show(fresh: Document): void {
  const next = fresh.getElementById("live") ?? fresh.body;
  for (const card of next.querySelectorAll<HTMLElement>("[data-robot]")) {
    const now = document.getElementById(card.id);
    const thumb = now?.querySelector(".thumb");
    if (!now || !thumb) continue;
    if (cards.has(now.dataset["live"] ?? "")) card.querySelector(".thumb")?.replaceWith(thumb.cloneNode(true));
    if (now.dataset["picture"]) card.dataset["picture"] = now.dataset["picture"];
    card.querySelector("details")?.toggleAttribute("open", now.querySelector("details")?.open ?? false);
  }
  const readers = live.querySelectorAll<HTMLDetailsElement>(".pending details[open]");
  for (const one of readers) next.querySelector(`#${one.id}`)?.toggleAttribute("open", true);
  const copy = live.cloneNode() as HTMLElement;
  copy.replaceChildren(...next.childNodes);
  morph(live, copy);
  for (const card of live.querySelectorAll<HTMLElement>("[data-live]")) {
    const slug = card.dataset["live"] ?? "";
    if (!cards.has(slug)) cards.set(slug, new LiveCard(card, [], () => void look()));
  }
}

function fail(words: string, ms = 0): void {
  say(line, words);
  line.hidden = false;
  until = performance.now() + ms;
}

async function parsed(answer: Response): Promise<Document> {
  return new DOMParser().parseFromString(await answer.text(), "text/html");
}

/** Look at the present state, at most once a second. */
async function look(): Promise<void> {
  wanted = true;
  if (looking) return;
  looking = true;
  while (wanted && !document.hidden) {
    wanted = false;
    try {
      const answer = await request(live.dataset["url"] ?? "", { headers: { Accept: "text/html" } });
      if (answer.redirected) {
        location.reload(); // signed out
        return;
      }
      if (!answer.ok) throw new Error(String(answer.status));
      show(await parsed(answer));
      if (performance.now() >= until) line.hidden = true;
    } catch {
      if (performance.now() >= until) fail(OLD);
    }
    await new Promise((done) => setTimeout(done, SOON_MS));
  }
  looking = false;
}

/** Send a form and stay here; its answer is this page with a message. */
async function send(form: HTMLFormElement): Promise<void> {
  try {
    const address = form.getAttribute("action") ?? ""; // `form.action` may be a field of that name
    const answer = await request(address, { method: "POST", body: new FormData(form) });
    const page = await parsed(answer);
    if (!answer.ok || !page.getElementById("live")) throw new Error(String(answer.status));
    const said = page.querySelector(".messagelist"); // of two presses at once, one answer may have the messages of both
    if (said) {
      document.querySelector(".messagelist")?.remove();
      said.setAttribute("role", "status");
      byId("content").before(said);
    }
    show(page);
    line.hidden = true;
  } catch {
    fail(UNANSWERED, READ_MS);
  }
}

live.addEventListener("submit", (event) => {
  const form = event.target as HTMLFormElement;
  if (!form.matches("[data-stays]")) return;
  event.preventDefault();
  void send(form);
});
document.addEventListener("visibilitychange", () => document.hidden || void look());
for (const card of live.querySelectorAll<HTMLElement>("[data-live]"))
  cards.set(card.dataset["live"] ?? "", new LiveCard(card, [], () => void look()));
if (cards.size) offerPause(() => cards.values());
every(SELDOM_MS, () => void look());
