/** The panel that shows whose turn it is and what you can do. */
import { type Part, refusal, show } from "../kit/parts.ts";
import { UNSENT } from "./person_socket.ts";
import type { Snapshot } from "../socket/protocol.ts";
import { Confirmation } from "../kit/confirmation.ts";
import { clock, timeOfDay } from "../kit/times.ts";
import { queueSentence, waitSentence } from "./waits.ts";

type Send = (message: object) => boolean;

const AGAIN = "Press again to end it";
const LATELY_MS = 3_600_000;
const FOLLOWS = "The robot goes back to its start position, for whoever comes next. You can write down what you found. You cannot undo this.";

export class TurnPanel {
  private ending = new Confirmation();
  private driving = false;
  private told = "";

  constructor(private box: HTMLElement, private send: Send, refuse: (why: () => string) => void) {
    box.addEventListener("click", (event) => {
      const button = (event.target as HTMLElement).closest<HTMLElement>("[data-do]"), action = button?.dataset["do"];
      if (button && refusal(button)) return refuse(() => refusal(button));
      if (action === "leave" && this.driving && !this.ending.press()) return this.ask();
      if (action) this.send({ t: action });
    });
  }

  /** Ask at once, on the button itself, not at the next drawing. */
  private ask(): void {
    const button = this.box.querySelector('[data-do="leave"]');
    if (button) button.textContent = AGAIN;
    const said = document.getElementById("say");
    if (said) said.textContent = `${AGAIN}. ${FOLLOWS}`;
  }

  /** Draw the panel; called at each snapshot and each second. */
  draw(s: Snapshot, now: number, up: boolean): void {
    this.driving = s.me.can.drive;
    show(this.box, this.parts(s, now).map((part) => (part.do ? { ...part, why: up ? "" : UNSENT } : part)));
  }

  /** Make the bar update too when something changed here, so that both show the same. */
  changed({ me }: Snapshot): void {
    const told = `${me.can.drive} ${me.ticket?.state}`;
    if (this.told && told !== this.told) document.dispatchEvent(new Event("farhand:place"));
    this.told = told;
  }

  private endParts(): Part[] {
    const { asking } = this.ending;
    return [
      { tag: "button", do: "leave", text: asking ? AGAIN : "End my turn" },
      ...(asking ? [{ tag: "p", text: FOLLOWS } as Part] : []),
    ];
  }

  private parts(s: Snapshot, now: number): Part[] {
    const slug = s.robot.slug;
    const { me } = s;
    if (me.can.drive && s.turn) {
      const left = s.turn.until_ms ? (s.turn.until_ms - now) / 1000 : 0;
      return [
        { tag: "h2", text: s.turn.staff ? "Maintenance turn" : "You drive" },
        { tag: "p", class: "timer", text: clock(left), timer: true },
        { tag: "p", text: s.turn.extra && !s.turn.wanted ? "Nobody waits, so your turn goes on." : "left in your turn" },
        ...(s.turn.staff ? [] : this.endParts()),
      ];
    }
    if (!s.robot.turns) return jobsOnly(s);
    if (!me.signed_in)
      return [
        { tag: "h2", text: "Drive it yourself" },
        { tag: "p", text: "Sign up, read the orientation, pass a short test, and wait your turn." },
        { tag: "a", href: `/accounts/signup/?next=/robots/${slug}/`, text: "Sign up", class: "button primary" },
        { tag: "a", href: `/accounts/login/?next=/robots/${slug}/`, text: "Sign in", class: "button" },
      ];
    const t = me.ticket;
    const over = t ? [] : ended(s, now);
    if (!me.cleared)
      return [
        ...over,
        { tag: "h2", text: "Two steps to go" },
        { tag: "p", text: "Read the orientation (three minutes), then pass the clearance test." },
        { tag: "a", href: `/robots/${slug}/orientation/`, text: "Read the orientation", class: "button primary" },
      ];
    if (t?.state === "offered") {
      const left = t.offer_until_ms ? (t.offer_until_ms - now) / 1000 : 0;
      return [
        { tag: "h2", text: "It is your turn" },
        { tag: "p", class: "timer", text: clock(left), timer: true },
        { tag: "button", do: "accept", text: "Take control", class: "primary" },
        { tag: "button", do: "leave", text: "Not now", class: "later" },
      ];
    }
    if (t?.state === "waiting")
      return [
        { tag: "h2", text: t.ahead === 0 ? "You are next" : `${t.ahead} before you` },
        { tag: "p", text: waitSentence(t.wait_s) },
        { tag: "p", class: "quiet", text: "You may look around: every page of this site tells you when it is your turn." },
        { tag: "button", do: "leave", text: "Leave the queue" },
      ];
    return [
      ...over,
      { tag: "h2", text: over.length ? "Drive it again" : "Drive it yourself" },
      { tag: "p", text: queueSentence(s.queue) },
      { tag: "button", do: "join", text: "Join the queue", class: "primary" },
    ];
  }
}

/** How the last turn ended, what it cost and what is next, as long as it is news or nothing was written about it. */
function ended({ me }: Snapshot, now: number): Part[] {
  const end = me.last_end;
  if (!end) return [];
  const news = now - end.ended_ms < LATELY_MS;
  return [
    { tag: "h2", text: news ? "Your turn is over" : "Your last turn" },
    { tag: "p", text: `It ended at ${timeOfDay(end.ended_ms)}. ${end.why}${news ? ` ${end.credited} ${end.next}` : ""}` },
    ...(end.written ? [] : [
      { tag: "p", text: "What did you find? Others read it." },
      { tag: "a", href: `/turns/${end.turn}/`, text: "Write in the operator's log", class: "button primary" },
    ] as Part[]),
  ];
}

/** A robot that nobody drives. */
function jobsOnly({ me, robot }: Snapshot): Part[] {
  const jobs = `/robots/${robot.slug}/jobs/`;
  const here = me.can.ask && document.getElementById("asking") !== null; // its console has a part for this
  return [
    { tag: "h2", text: "It works by itself" },
    { tag: "p", text: me.can.ask ? "Nobody drives this robot. Ask it for something, and watch." : "Nobody drives this robot. It takes jobs from people with clearance." },
    { tag: "a", href: here ? "#asking" : jobs, text: me.can.ask ? "Ask for a job" : "See its jobs", class: "button primary" },
    ...(here ? [{ tag: "a", href: jobs, text: "All jobs" } as Part] : []),
  ];
}
