/** The bar on every page: the person's most urgent place, with countdown and button. */
import { LEAVE, type Leaving } from "./leaving.ts";
import { type Part, say, show } from "./parts.ts";
import { PersonLine, type Standing, type Wanted } from "./person.ts";
import { current, shownOf } from "./shown.ts";
import { Teller } from "./tell.ts";
import { clock, span } from "./words.ts";

const ASK = "ask-"; // names of the bar's own buttons; the page may have others to join and accept

class TurnBar {
  private own: string;
  private home: string;
  private line: PersonLine;
  private teller: Teller;
  private words = box("turnbar-words");
  private buttons = box("turnbar-do");
  private also = box("turnbar-also");
  private said = box("turnbar-said");
  /** The place that the words and buttons on the page are for. */
  private place: Standing | undefined;
  private leaving: Leaving | null = null;
  private busy = false;
  private fading = 0;
  private take: (() => void) | null;
  private bar: HTMLElement;

  constructor(bar: HTMLElement, form: HTMLFormElement) {
    this.bar = bar;
    this.own = bar.dataset["own"] ?? "";
    this.home = bar.dataset["home"] ?? "";
    const token = form.querySelector<HTMLInputElement>("[name=csrfmiddlewaretoken]")?.value ?? "";
    this.said.setAttribute("role", "status");
    const polite = region("polite"), assertive = region("assertive");
    document.body.append(polite, assertive);
    this.teller = new Teller(polite, assertive, (place) => this.lead(place));
    this.line = new PersonLine(token, () => this.draw());
    const inner = document.createElement("div");
    inner.className = "turnbar-in";
    inner.append(this.words, this.buttons, this.also, this.said);
    this.take = () => form.replaceWith(inner);
    this.buttons.addEventListener("click", (event) => {
      const wanted = (event.target as HTMLElement).closest<HTMLElement>("[data-do]")?.dataset["do"];
      if (wanted?.startsWith(ASK)) void this.press(wanted.slice(ASK.length));
    });
    document.addEventListener(LEAVE, (event) => {
      this.leaving = (event as CustomEvent<Leaving>).detail;
      this.draw();
      this.buttons.querySelector<HTMLElement>("button")?.focus();
    });
    new ResizeObserver(() => document.documentElement.style.setProperty("--bar-height", `${bar.offsetHeight}px`)).observe(bar);
    setInterval(() => this.draw(), 500);
  }

  private draw(): void {
    if (!this.line.known) return; // the server's text stays until more is known
    this.take?.();
    this.take = null;
    const now = this.line.now();
    const places = current(this.line.places, now);
    this.teller.tell(places, now, this.own);
    const [first, ...rest] = shownOf(places, this.own);
    this.place = first;
    if (this.leaving && !this.leaving.operating()) this.leaving = null;
    this.bar.hidden = !first && !this.leaving && !this.said.textContent;
    this.bar.dataset["state"] = this.leaving ? "leaving" : (first?.state ?? "");
    show(this.words, this.leaving ? LEAVE_WORDS : first ? [...wordsOf(first, now), ...badge(first)] : []);
    show(this.buttons, this.leaving ? LEAVE_BUTTONS : first ? this.buttonsOf(first) : []);
    say(this.also, this.leaving ? "" : rest.map((p) => short(p, now)).join(" "));
  }

  private buttonsOf(p: Standing): Part[] {
    const ask = (what: string, text: string, more: Partial<Part> = {}): Part =>
      ({ tag: "button", do: ASK + what, text, disabled: this.busy, ...more });
    if (p.state === "offered") return [ask("accept", "Take control", { class: "primary" }), ask("leave", "Not now")];
    if (p.state === "operating") return [{ tag: "a", href: `/robots/${p.robot}/`, text: `Back to ${p.name}`, class: "button primary" }];
    if (p.state === "missed") return [ask("join", "Join again", { class: "primary" }), ask("dismiss", "Dismiss")];
    const notify = "Notification" in window && Notification.permission === "default";
    return [
      ...(notify ? [ask("notify", "Tell me when it is my turn")] : []),
      ask("sound", "Sound", { pressed: this.teller.sound }),
    ];
  }

  private async press(wanted: string): Promise<void> {
    if (wanted === "go" || wanted === "stay") {
      const leaving = this.leaving;
      this.leaving = null;
      this.draw();
      if (wanted === "go") leaving?.go();
      return;
    }
    if (wanted === "sound") this.teller.sound = !this.teller.sound;
    else if (wanted === "notify") await this.notify();
    else await this.carryOut(wanted as Wanted);
    this.draw();
  }

  private async carryOut(wanted: Wanted): Promise<void> {
    const place = this.place;
    if (!place || this.busy) return;
    this.busy = true;
    this.tell("");
    const wrong = await this.line.ask(wanted, place);
    this.busy = false;
    this.tell(wrong);
    if (!wrong && wanted === "accept") this.lead(place);
  }

  private async notify(): Promise<void> {
    const answer = await Notification.requestPermission();
    this.tell(answer === "granted" ? "This browser will notify you." : "This browser may not notify you. Keep this page open: its title and a sound tell you.");
  }

  private tell(words: string): void {
    clearTimeout(this.fading);
    say(this.said, words);
    if (words) this.fading = window.setTimeout(() => say(this.said, ""), 12_000);
  }

  /** Open the robot's page, unless this is it. */
  private lead(place: Standing): void {
    if (place.robot !== this.own) location.assign(`/robots/${place.robot}/`);
    else if (this.home) location.assign(this.home);
    else document.getElementById("screen")?.focus({ preventScroll: false });
  }
}

const LEAVE_WORDS: Part[] = [
  { tag: "b", text: "Leave in the middle of your turn?" },
  { tag: "span", text: "It goes on for 20 s after you leave this page, and ends then unless you come back." },
];
const LEAVE_BUTTONS: Part[] = [
  { tag: "button", do: `${ASK}stay`, text: "Stay", class: "primary" },
  { tag: "button", do: `${ASK}go`, text: "Leave the page" },
];

function left(p: Standing, now: number): string {
  return clock((((p.kept_until_ms ?? p.until_ms) ?? now) - now) / 1000);
}

function badge(p: Standing): Part[] {
  return p.simulated ? [{ tag: "span", class: "simulated", text: "Simulated" }] : [];
}

function wordsOf(p: Standing, now: number): Part[] {
  if (p.state === "offered")
    return [{ tag: "b", text: `It is your turn on ${p.name}` }, { tag: "span", class: "turnbar-timer", text: left(p, now), timer: true }];
  if (p.state === "operating")
    return [
      { tag: "b", text: p.kept_until_ms === null ? `You operate ${p.name}` : `Go back to ${p.name}, or your turn ends` },
      { tag: "span", class: "turnbar-timer", text: left(p, now), timer: true },
    ];
  if (p.state === "missed") return [{ tag: "b", text: missed(p) }];
  return [
    { tag: "b", text: p.ahead === 0 ? "You are next" : `${p.ahead} before you` },
    { tag: "span", text: " for " }, { tag: "a", href: `/robots/${p.robot}/`, text: p.name }, { tag: "span", class: "quiet", text: ` ${wait(p)}` },
  ];
}

function missed(p: Standing): string {
  const ended = new Date(p.ended_ms ?? 0);
  const time = ended.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
  const at = ended.toDateString() === new Date().toDateString() ? time : `${ended.toLocaleDateString()} ${time}`;
  return p.away
    ? `You were away for too long: your place for ${p.name} was given to the next person at ${at}.`
    : `You missed your turn on ${p.name} at ${at}; the place was given to the next person.`;
}

function wait(p: Standing): string {
  if (p.wait_s === null) return "The wait is not known; your place is kept.";
  return p.wait_s[1] < 10 ? "Any moment now." : `About ${span(p.wait_s[0])} to ${span(p.wait_s[1])}.`;
}

function short(p: Standing, now: number): string {
  if (p.state === "waiting") return `${p.name}: ${p.ahead === 0 ? "you are next" : `${p.ahead} before you`}.`;
  if (p.state === "missed") return missed(p);
  return `${p.name}: ${p.state === "offered" ? "offered to you" : "your turn"}, ${left(p, now)}.`;
}

function box(name: string): HTMLElement {
  const made = document.createElement(name === "turnbar-do" ? "div" : "p");
  made.className = name;
  return made;
}

function region(live: "polite" | "assertive"): HTMLElement {
  const made = document.createElement("p");
  made.className = "visually-hidden";
  made.setAttribute("aria-live", live);
  return made;
}

const bar = document.getElementById("turnbar");
const form = bar?.querySelector("form");
if (bar && form) new TurnBar(bar, form);
