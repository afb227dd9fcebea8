/** The bar on every page: the person's most urgent place, with countdown and button. */
import { make, say } from "../kit/dom.ts";
import { every } from "../kit/page_clock.ts";
import { button, drawParts, inlineCountdown, link, type Part, strong, words } from "../kit/render.ts";
import { focusStage } from "../kit/stage_focus.ts";
import { clock, timeOfDay } from "../kit/times.ts";
import { gettext, ngettext, translate } from "../kit/text.ts";
import { SOUND_ACTION, Announcer } from "./announcer.ts";
import { LEAVE_EVENT, type LeaveRequest } from "./leave_guard.ts";
import { MailChoice } from "./choices.ts";
import { Notices } from "./notices.ts";
import { barPlaces, currentPlaces, PersonSocket, type PlaceAction, type QueuePlace } from "./person_socket.ts";
import { before, waitSentence } from "./waits.ts";

const BUSY = gettext("Your last press is on its way.");
const ASK = "ask-"; // names of the bar's own buttons; the page may have others to join and accept

class TurnBar {
  private own: string;
  private home: string;
  private line: PersonSocket;
  private teller: Announcer;
  private notices: Notices;
  private mail: MailChoice;
  private words = make("p", { class: "turnbar-words" });
  private buttons = make("div", { class: "turnbar-do" });
  private also = make("p", { class: "turnbar-also" });
  private said = make("p", { class: "turnbar-said", role: "status" });
  private place: QueuePlace | undefined; // what the words and buttons are for
  private leaving: LeaveRequest | null = null;
  private busy = false;
  private fading = 0;
  private read = new Set<number>(); // tickets whose end this page has told
  private take: (() => void) | null;
  private bar: HTMLElement;

  constructor(bar: HTMLElement, form: HTMLFormElement) {
    this.bar = bar;
    this.own = bar.dataset["own"] ?? "";
    this.home = bar.dataset["home"] ?? "";
    const token = form.querySelector<HTMLInputElement>("[name=csrfmiddlewaretoken]")?.value ?? "";
    const polite = make("p", { class: "visually-hidden", "aria-live": "polite" });
    const assertive = make("p", { class: "visually-hidden", "aria-live": "assertive", role: "alert" });
    document.body.append(polite, assertive);
    this.notices = new Notices(bar.dataset["push"] ?? "", token, bar.dataset["told"] === "yes", () => this.draw());
    this.mail = new MailChoice(bar.dataset["mail"] ?? "", token);
    this.teller = new Announcer(polite, assertive, (place) => this.lead(place), this.notices);
    this.line = new PersonSocket(token, () => this.draw());
    const inner = make("div", { class: "turnbar-in" }, this.words, this.buttons, this.also, this.said);
    this.take = () => form.replaceWith(inner);
    this.buttons.addEventListener("click", (event) => {
      const wanted = (event.target as HTMLElement).closest<HTMLElement>("[data-do]")?.dataset["do"];
      if (wanted?.startsWith(ASK)) void this.press(wanted.slice(ASK.length));
    });
    document.addEventListener(LEAVE_EVENT, (event) => {
      this.leaving = (event as CustomEvent<LeaveRequest>).detail;
      this.draw();
      this.buttons.querySelector<HTMLElement>("button")?.focus();
    });
    document.addEventListener("farhand:acted", () => this.place?.idles && this.line.look());
    new ResizeObserver(() => this.measure()).observe(bar);
    every(500, () => this.draw());
  }

  /** Tell the styles how high the bar is: at the foot of the page, or over its head where it warns of idleness. */
  private measure(): void {
    const idle = this.bar.dataset["state"] === "idle",
      height = this.bar.offsetHeight;
    document.documentElement.style.setProperty("--bar-height", `${idle ? 0 : height}px`);
    document.documentElement.style.setProperty("--idle-height", `${idle ? height : 0}px`);
  }

  private draw(): void {
    if (!this.line.known) return; // the server's text stays until more is known
    this.take?.();
    this.take = null;
    const now = this.line.now();
    const places = currentPlaces(this.line.places, now).filter((p) => !this.isTaken(p));
    this.teller.tell(places, now, this.own);
    this.seen(places);
    const [first, ...rest] = barPlaces(places, this.own);
    this.place = first;
    if (this.leaving && !this.leaving.operating()) this.leaving = null;
    this.bar.toggleAttribute("data-here", !this.leaving && first !== undefined && first.robot === this.own && !first.idles);
    this.bar.hidden = !first && !this.leaving && !this.said.textContent;
    const state = this.leaving ? "leaving" : first && first.idles ? "idle" : (first?.state ?? "");
    const other = this.bar.dataset["state"] !== state;
    this.bar.dataset["state"] = state;
    drawParts(this.words, this.leaving ? LEAVE_WORDS : first ? wordsOf(first, now, this.own) : []);
    drawParts(this.buttons, this.leaving ? LEAVE_BUTTONS : first ? this.buttonsOf(first) : []);
    const also = rest.map((p) => short(p, now));
    if (first?.state === "waiting" && this.teller.paused)
      also.push(
        this.teller.ran
          ? gettext("Sound paused. Press Sound to hear when it is your turn.")
          : gettext("Press Sound to hear when it is your turn."),
      );
    say(this.also, this.leaving ? "" : also.join(" "));
    if (other) this.measure(); // with all its parts drawn: the observer is silent where the new ones are as high as the old
  }

  /** Whether the page itself asks for control and accepts the offer of this place: then nobody need do so. */
  private isTaken(p: QueuePlace): boolean {
    const before = p.state === "waiting" || p.state === "offered";
    return before && p.robot === this.own && document.querySelector("#place[data-asking]") !== null;
  }

  /** Dismiss an ended turn that the page itself tells, so that other pages do not say it again. */
  private seen(places: readonly QueuePlace[]): void {
    const here = (p: QueuePlace): boolean => p.robot === this.own || location.pathname === `/turns/${p.turn}/`;
    const told = places.find((p) => p.state === "ended" && p.turn !== null && here(p));
    if (!told || document.hidden || this.read.has(told.ticket)) return;
    this.read.add(told.ticket);
    void this.line.ask("dismiss", told);
  }

  private buttonsOf(p: QueuePlace): Part[] {
    const why = this.busy ? BUSY : "";
    const ask = (action: string, text: string, style = ""): Part => button(text, ASK + action, { style, why });
    if (p.state === "offered") return [ask("accept", gettext("Take control"), "primary"), ask("leave", gettext("Not now"))];
    if (p.idles) return [ask("stay", gettext("I'm here"), "primary")];
    if (p.state === "operating") return [link(gettext("Back to {name}", { name: p.name }), `/robots/${p.robot}/`, "button primary")];
    if (p.state === "missed") return [ask("join", gettext("Join again"), "primary"), ask("dismiss", gettext("Dismiss"))];
    if (p.state === "ended") {
      const page = p.turn === null ? [] : [link(gettext("What did you find?"), `/turns/${p.turn}/`, "button primary")];
      return [...page, ask("dismiss", gettext("Dismiss"))];
    }
    const { offered, on } = this.notices;
    return [
      ...(offered ? [button(gettext("Tell me when it is my turn"), `${ASK}notify`, { pressed: on })] : []),
      ...(this.mail.offered ? [button(gettext("Also by e-mail"), `${ASK}mail`, { pressed: this.mail.on })] : []),
      button(gettext("Sound"), SOUND_ACTION, { pressed: this.teller.sound && !this.teller.paused }),
    ];
  }

  private async press(wanted: string): Promise<void> {
    if (wanted === "go" || wanted === "keep") {
      const leaving = this.leaving;
      this.leaving = null;
      this.draw();
      if (wanted === "go") leaving?.go();
      return;
    }
    if (wanted === "sound") this.teller.press();
    else if (wanted === "notify") this.tell(await this.notices.press());
    else if (wanted === "mail") this.tell(await this.mail.press());
    else await this.carryOut(wanted as PlaceAction);
    this.draw();
  }

  private async carryOut(wanted: PlaceAction): Promise<void> {
    const place = this.place;
    if (!place) return;
    if (this.busy) {
      this.tell(BUSY);
      return;
    }
    this.busy = true;
    this.tell("");
    const wrong = await this.line.ask(wanted, place);
    this.busy = false;
    this.tell(wrong);
    if (!wrong && wanted === "accept") this.lead(place);
    if (wanted === "stay" && place.robot === this.own) focusStage(); // where Escape stops
  }

  private tell(words: string): void {
    clearTimeout(this.fading);
    say(this.said, words);
    if (words) this.fading = window.setTimeout(() => say(this.said, ""), 12_000);
  }

  /** Open the robot's page, unless this is it. */
  private lead(place: QueuePlace): void {
    if (place.robot !== this.own) location.assign(`/robots/${place.robot}/`);
    else if (this.home) location.assign(this.home);
    else focusStage();
  }
}

const LEAVE_WORDS: Part[] = [
  strong(gettext("Leave in the middle of your turn?")),
  words(gettext("It goes on for 20 s after you leave this page, and ends then unless you come back.")),
];
const LEAVE_BUTTONS: Part[] = [button(gettext("Stay"), `${ASK}keep`, { style: "primary" }), button(gettext("Leave the page"), `${ASK}go`)];

function left(p: QueuePlace, now: number): string {
  return clock(((p.kept_until_ms ?? p.until_ms ?? now) - now) / 1000);
}

function timer(text: string): Part {
  return inlineCountdown(text, "turnbar-timer");
}

/** Return what the bar says of a place; the page of the robot `own` says itself that the robot is simulated. */
function wordsOf(p: QueuePlace, now: number, own: string): Part[] {
  const badge = p.simulated && !(p.idles && p.robot === own) ? [words(gettext("Simulated"), "simulated")] : [];
  return [...stateOf(p, now, own), ...badge];
}

function stateOf(p: QueuePlace, now: number, own: string): Part[] {
  if (p.state === "offered") return [strong(gettext("It is your turn on {name}", { name: p.name })), timer(left(p, now))];
  if (p.idles)
    return [
      strong(p.robot === own ? gettext("Your turn ends in") : gettext("Your turn on {name} ends in", { name: p.name })),
      timer(`${Math.max(0, Math.ceil(((p.idle_ms ?? now) - now) / 1000))} s`),
      words(gettext("because nothing was done.")),
    ];
  if (p.state === "operating")
    return [
      strong(
        p.kept_until_ms === null
          ? gettext("You operate {name}", { name: p.name })
          : gettext("Go back to {name}, or your turn ends", { name: p.name }),
      ),
      timer(left(p, now)),
    ];
  if (p.state === "missed" || p.state === "ended") return [strong(over(p))];
  return [
    strong(p.ahead === 0 ? gettext("You are next") : before(p.ahead)),
    words(gettext(" for ")),
    link(p.name, `/robots/${p.robot}/`),
    words(` ${waitSentence(p.wait_s)}`, "quiet"),
  ];
}

/** Return what was lost or is over, when, why and what it cost. */
function over(p: QueuePlace): string {
  const values = { name: p.name, time: timeOfDay(p.ended_ms ?? 0) };
  const what =
    p.turn !== null
      ? gettext("Your turn on {name} ended at {time}.", values)
      : p.away || p.state === "ended"
        ? gettext("You lost your place for {name} at {time}.", values)
        : gettext("You missed your turn on {name} at {time}.", values);
  return `${what}${p.end ? ` ${translate(p.end.why)} ${translate(p.end.credited)}` : ""}`;
}

function short(p: QueuePlace, now: number): string {
  const { name } = p;
  if (p.state === "waiting")
    return p.ahead === 0
      ? gettext("{name}: you are next.", { name })
      : ngettext("{name}: {count} before you.", "{name}: {count} before you.", p.ahead, { name });
  if (p.state === "missed" || p.state === "ended") return over(p);
  const values = { name, time: left(p, now) };
  return p.state === "offered" ? gettext("{name}: offered to you, {time}.", values) : gettext("{name}: your turn, {time}.", values);
}

const bar = document.getElementById("turnbar");
const form = bar?.querySelector("form");
if (bar && form) new TurnBar(bar, form);
