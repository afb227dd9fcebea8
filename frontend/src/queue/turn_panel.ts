/** The panel that shows whose turn it is and what you can do. */
import { refusal } from "../kit/refusal.ts";
import { button, countdown, drawParts, heading, link, paragraph, type Part } from "../kit/render.ts";
import { clock, timeOfDay } from "../kit/times.ts";
import type { Snapshot } from "../socket/messages.ts";
import { UNSENT } from "./person_socket.ts";
import { queueSentence, waitSentence } from "./waits.ts";

const AGAIN = "Press again to end it";
const LATELY_MS = 3_600_000;
const ASKED_MS = 8000; // how long the question is shown
const DOUBLE_MS = 400; // a double click is one press
const TAKE_MS = 15_000; // after this time one decides about an offer anew
const FOLLOWS =
  "The robot goes back to its start position, for whoever comes next. You can write down what you found. You cannot undo this.";

const STAYS_SHUT = "The robot stays locked out until staff lift that.";

/** Confirmation of an action that cannot be undone: the same button, in the same place, is pressed again. */
class Confirmation {
  private asked = -Infinity;

  /** Whether the question is shown. */
  get asking(): boolean {
    return performance.now() - this.asked < ASKED_MS;
  }

  /** Take a press. Returns whether it is the second one, which confirms. */
  press(): boolean {
    const since = performance.now() - this.asked;
    if (since < DOUBLE_MS) return false;
    const sure = since < ASKED_MS;
    this.asked = sure ? -Infinity : performance.now();
    return sure;
  }
}

/** The parts of the page that `TurnPanel` needs. */
interface TurnPanelUse {
  readonly live: { send(message: object): boolean };
  refuse(why: () => string): void;
}

/** `wanted`: the page before asked for control, as soon as this one is open. */
export class TurnPanel {
  private ending = new Confirmation();
  private driving = false;
  private told = "";
  private drawn: [s: Snapshot, now: number, up: boolean] | null = null;
  private taking = -Infinity; // when control of the free robot was asked for

  private box: HTMLElement;
  private use: TurnPanelUse;
  private wanted: boolean;

  constructor(box: HTMLElement, use: TurnPanelUse, wanted = false) {
    [this.box, this.use, this.wanted] = [box, use, wanted];
    box.addEventListener("click", (event) => {
      const button = (event.target as HTMLElement).closest<HTMLElement>("[data-do]"),
        action = button?.dataset["do"];
      if (button && refusal(button)) use.refuse(() => refusal(button));
      else if (action === "leave" && this.driving && !this.ending.press()) this.ask();
      else if (action === "take") this.take();
      else if (action) {
        this.taking = -Infinity;
        use.live.send({ t: action });
      }
    });
  }

  /** Join the queue of a robot for which nobody waits; its offer is accepted as soon as it comes. */
  private take(): void {
    if (this.use.live.send({ t: "join" })) this.taking = performance.now();
  }

  /** Show the question on the button at once, not at the next drawing. */
  private ask(): void {
    if (this.drawn) this.draw(...this.drawn);
    const said = document.getElementById("say");
    if (said) said.textContent = `${AGAIN}. ${this.drawn?.[0].turn?.staff ? STAYS_SHUT : FOLLOWS}`;
  }

  /** Draw the panel. `up`: whether there is a connection. */
  draw(s: Snapshot, now: number, up: boolean): void {
    this.drawn = [s, now, up];
    this.driving = s.me.can.drive;
    drawParts(this.box, this.parts(s, now, up ? "" : UNSENT));
  }

  /** Take control where it was asked for, and make the turn bar update, so that both show the same. */
  changed(s: Snapshot): void {
    const { me } = s;
    if (this.wanted && me.cleared && !me.ticket && s.robot.free) this.take();
    else if (me.ticket?.state === "offered" && performance.now() - this.taking < TAKE_MS) {
      this.taking = -Infinity;
      this.use.live.send({ t: "accept" });
    }
    this.wanted = false;
    const told = `${me.can.drive} ${me.ticket?.state}`;
    if (this.told && told !== this.told) document.dispatchEvent(new Event("farhand:place"));
    this.told = told;
  }

  private endParts(staff: boolean, why: string): Part[] {
    const { asking } = this.ending,
      name = staff ? "End maintenance" : "End my turn";
    return [button(asking ? AGAIN : name, "leave", { why }), ...(asking ? [paragraph(staff ? STAYS_SHUT : FOLLOWS)] : [])];
  }

  /** Return the parts of the panel; `why`: why no button works now. */
  private parts(s: Snapshot, now: number, why: string): Part[] {
    const { me } = s,
      { slug } = s.robot;
    if (me.can.drive && s.turn) {
      const left = s.turn.until_ms ? (s.turn.until_ms - now) / 1000 : 0;
      return [
        heading(s.turn.staff ? "Maintenance turn" : "You drive"),
        countdown(clock(left)),
        paragraph(s.turn.extra && !s.turn.wanted ? "Nobody waits, so your turn goes on." : "left in your turn"),
        ...this.endParts(s.turn.staff, why),
        ...(s.turn.staff ? [link("All robots, for staff", "/admin/")] : []),
      ];
    }
    if (!s.robot.turns) return jobsOnly(s);
    if (!me.signed_in)
      return [
        heading("Drive it yourself"),
        paragraph("Sign up, read the orientation, pass a short test, and wait your turn."),
        link("Sign up", `/accounts/signup/?next=/robots/${slug}/`, "button primary"),
        link("Sign in", `/accounts/login/?next=/robots/${slug}/`, "button"),
      ];
    const t = me.ticket;
    const over = t ? [] : ended(s, now);
    if (!me.cleared)
      return [
        ...over,
        heading("Two steps to go"),
        paragraph("Read the orientation (three minutes), then pass the clearance test."),
        link("Read the orientation", `/robots/${slug}/orientation/`, "button primary"),
      ];
    if (t?.state === "offered") {
      const left = t.offer_until_ms ? (t.offer_until_ms - now) / 1000 : 0;
      return [
        heading("It is your turn"),
        countdown(clock(left)),
        button("Take control", "accept", { style: "primary", why }),
        button("Not now", "leave", { style: "later", why }),
      ];
    }
    if (t?.state === "waiting")
      return [
        heading(t.ahead === 0 ? "You are next" : `${t.ahead} before you`),
        paragraph(waitSentence(t.wait_s)),
        paragraph("You may look around: every page of this site tells you when it is your turn.", "quiet"),
        button("Leave the queue", "leave", { why }),
      ];
    return [
      ...over,
      heading(over.length ? "Drive it again" : "Drive it yourself"),
      paragraph(s.robot.free ? "Nobody waits: it is yours at once." : queueSentence(s.queue)),
      s.robot.free
        ? button("Take control", "take", { style: "primary", why })
        : button("Join the queue", "join", { style: "primary", why }),
    ];
  }
}

/** Return how the last turn ended, what it cost and what is next, if the snapshot still tells it. */
function ended({ me }: Snapshot, now: number): Part[] {
  const end = me.last_end;
  if (!end) return [];
  const news = now - end.ended_ms < LATELY_MS;
  const ask = [
    paragraph("What did you find? Others read it."),
    link("Write in the operator's log", `/turns/${end.turn}/`, "button primary"),
  ];
  return [
    heading(news ? "Your turn is over" : "Your last turn"),
    paragraph(`It ended at ${timeOfDay(end.ended_ms)}. ${end.why}${news ? ` ${end.credited} ${end.next}` : ""}`),
    ...(end.written ? [] : ask),
  ];
}

/** Return the panel of a robot that nobody drives. */
function jobsOnly({ me, robot }: Snapshot): Part[] {
  const jobs = `/robots/${robot.slug}/jobs/`;
  const here = me.can.ask && document.getElementById("asking") !== null; // its console has a part for this
  return [
    heading("It works by itself"),
    paragraph(`Nobody drives this robot. ${me.can.ask ? "Ask it for something, and watch." : "It takes jobs from people with clearance."}`),
    link(me.can.ask ? "Ask for a job" : "See its jobs", here ? "#asking" : jobs, "button primary"),
    ...(here ? [link("All jobs", jobs)] : []),
  ];
}
