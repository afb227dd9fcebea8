/** The panel that shows whose turn it is and what you can do. */
import { refusal } from "../kit/refusal.ts";
import { bubble, button, countdown, drawParts, heading, link, paragraph, type Part, strong } from "../kit/render.ts";
import { clock, timeOfDay } from "../kit/times.ts";
import { gettext, translate } from "../kit/text.ts";
import type { Snapshot } from "../socket/messages.ts";
import { type Asked, ASKING, Asking } from "./asking.ts";
import { UNANSWERED, UNSENT } from "./person_socket.ts";
import { before, joinWait, queueSentence, waitSentence } from "./waits.ts";

const AGAIN = gettext("Press again to end it");
const LATELY_MS = 3_600_000;
const ASKED_MS = 8000; // how long the question is shown
const DOUBLE_MS = 400; // a double click is one press
const FOLLOWS = gettext(
  "The robot goes back to its start position, for whoever comes next. You can write down what you found. You cannot undo this.",
);
const PRACTICE_FOLLOWS = gettext("The simulator goes back to its start position, for whoever comes next.");

const STAYS_SHUT = gettext("The robot stays locked out until staff lift that.");

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
  readonly live: { send(message: object): boolean; heardSince(at: number): boolean };
  refuse(why: () => string): void;
}

/** `wanted`: the page before asked for control, as soon as this one is open. */
export class TurnPanel {
  private ending = new Confirmation();
  private driving = false;
  private told = "";
  private drawn: [s: Snapshot, now: number, up: boolean] | null = null;
  private sent = -Infinity; // when the last press was sent
  private asked: Asking | null = null;

  private box: HTMLElement;
  private use: TurnPanelUse;
  private wanted: boolean;

  constructor(box: HTMLElement, use: TurnPanelUse, wanted = false) {
    [this.box, this.use, this.wanted] = [box, use, wanted];
    if (wanted) drawParts(box, [heading(ASKING)]);
    box.addEventListener("click", (event) => {
      const button = (event.target as HTMLElement).closest<HTMLElement>("[data-do]"),
        action = button?.dataset["do"];
      if (button && refusal(button)) use.refuse(() => refusal(button));
      else if (action === "leave" && this.driving && !this.ending.press()) this.tell(`${AGAIN}. ${this.follows()}`);
      else if (action === "practise") practise();
      else if (action === "take" || action === "join" || action === "accept") this.begin(action, this.drawn?.[0] ?? null);
      else if (action) {
        this.asked = null;
        this.send(action);
      }
    });
  }

  /** The press whose result is not known yet. */
  private get asking(): Asking | null {
    return this.asked?.late ? null : this.asked;
  }

  private begin(what: Asked, shown: Snapshot | null): void {
    if (!this.send(what === "take" ? "join" : what)) return;
    this.asked = new Asking(what, shown);
    this.tell(this.asked.words);
  }

  /** The portal refused what was asked for. */
  refused(): void {
    this.asked = null;
  }

  private send(t: string): boolean {
    const sent = this.use.live.send({ t });
    if (sent) this.sent = performance.now();
    return sent;
  }

  /** Show what a press did at once, not at the next drawing, and say it. */
  private tell(words: string): void {
    if (this.drawn) this.draw(...this.drawn);
    speak(words);
  }

  /** Draw the panel. `up`: whether there is a connection. */
  draw(s: Snapshot, now: number, up: boolean): void {
    this.drawn = [s, now, up];
    this.driving = s.me.can.drive;
    const why = this.use.live.heardSince(this.sent) ? UNSENT : UNANSWERED;
    this.box.toggleAttribute("data-asking", this.asking?.what === "take");
    drawParts(this.box, this.parts(s, now, up ? "" : why));
  }

  /** Take control where it was asked for, and make the turn bar update, so that both show the same. */
  changed(s: Snapshot): void {
    const { me } = s;
    const next = this.asked?.follow(s);
    if (this.wanted && me.cleared && !me.ticket && (isSoon(s) || s.robot.practice)) this.begin("take", s);
    else if (next === "over") {
      this.asked = null;
      if (me.can.drive) speak(begun(s)); // who hears the page has heard of no offer
    } else if (next === "accept") this.send("accept");
    this.wanted = false;
    const told = `${me.can.drive} ${me.ticket?.state}`;
    if (this.told && told !== this.told) document.dispatchEvent(new Event("farhand:place"));
    this.told = told;
  }

  private follows(): string {
    const drawn = this.drawn?.[0];
    return drawn?.turn?.staff ? STAYS_SHUT : drawn?.robot.practice ? PRACTICE_FOLLOWS : FOLLOWS;
  }

  private endParts(staff: boolean, why: string): Part[] {
    const { asking } = this.ending,
      name = staff ? gettext("End maintenance") : gettext("End my turn");
    return [button(asking ? AGAIN : name, "leave", { why }), ...(asking ? [paragraph(this.follows(), "follows")] : [])];
  }

  /** Return the parts of the panel; `why`: why no button works now. */
  private parts(s: Snapshot, now: number, why: string): Part[] {
    const { asking } = this;
    if (!asking || asking.what === "accept") return this.partsOf(s, now, why);
    const cancel = asking.what === "take" ? [button(gettext("Cancel"), "leave", { why })] : [];
    return [...this.partsOf(asking.shown ?? s, now, why), bubble([strong(asking.words), ...cancel])];
  }

  private partsOf(s: Snapshot, now: number, why: string): Part[] {
    const { me } = s,
      { slug } = s.robot,
      held = why || (this.asking?.words ?? "");
    if (me.can.drive && s.turn) {
      const left = s.turn.until_ms ? (s.turn.until_ms - now) / 1000 : 0;
      return [
        heading(begun(s)),
        countdown(clock(left)),
        paragraph(s.turn.extra && !s.turn.wanted ? gettext("Nobody waits, so your turn goes on.") : gettext("left in your turn")),
        ...this.endParts(s.turn.staff, why),
      ];
    }
    if (!s.robot.turns) return jobsOnly(s);
    if (!me.signed_in) return s.robot.practice ? beforePractice(s, why) : strangerParts(slug);
    const t = me.ticket;
    const over = t ? [] : ended(s, now);
    if (me.guest && over.length) return [...over, ...afterPractice(s, held)];
    if (!me.cleared) return [...over, ...stepsToGo(s), ...practiceLink(gettext("Practise on a simulator"))];
    if (t?.state === "offered") {
      const left = t.offer_until_ms ? (t.offer_until_ms - now) / 1000 : 0;
      return [
        heading(this.asking?.words ?? gettext("It is your turn")),
        countdown(clock(left)),
        button(gettext("Take control"), "accept", { style: "primary", why: held }),
        button(gettext("Not now"), "leave", { style: "later", why }),
      ];
    }
    if (t?.state === "waiting")
      return [
        heading(t.ahead === 0 ? gettext("You are next") : before(t.ahead)),
        paragraph(waitSentence(t.wait_s)),
        paragraph(gettext("You may look around: every page of this site tells you when it is your turn."), "quiet"),
        ...practiceLink(gettext("Practise while you wait")),
        button(gettext("Leave the queue"), "leave", { why }),
      ];
    const soon = isSoon(s);
    const wait = soon ? "" : joinWait(s.robot.state, false, s.join_wait_s ?? null);
    return [
      ...over,
      heading(over.length ? gettext("Drive it again") : gettext("Drive it yourself")),
      paragraph(soon ? soonWords(s) : queueSentence(s.queue)),
      ...(wait ? [paragraph(wait)] : []),
      soon
        ? button(gettext("Take control"), "take", { style: "primary", why: held })
        : button(gettext("Join the queue"), "join", { style: "primary", why: held }),
    ];
  }
}

/** Have screen readers say it. */
function speak(words: string): void {
  const line = document.getElementById("say");
  if (line) line.textContent = words;
}

/** Return what one's turn is called while it goes on. */
function begun({ turn, robot }: Snapshot): string {
  return turn?.staff ? gettext("Maintenance turn") : robot.practice ? gettext("You practise") : gettext("You drive");
}

/** Return whether somebody who joins now drives within seconds, so that one press does both. */
function isSoon({ robot }: Snapshot): boolean {
  return robot.soon ?? robot.free ?? false;
}

function soonWords({ robot }: Snapshot): string {
  return robot.free ? gettext("Nobody waits: it is yours at once.") : gettext("Nobody waits: it is yours in some seconds.");
}

/** Return what is left to do until somebody who is signed in may drive. */
function stepsToGo({ me, robot }: Snapshot): Part[] {
  if (me.read)
    return [
      heading(gettext("One step to go")),
      paragraph(gettext("You have read the orientation. Now pass the clearance test.")),
      link(gettext("Take the clearance test"), `/robots/${robot.slug}/clearance/`, "button primary"),
    ];
  return [
    heading(gettext("Two steps to go")),
    paragraph(gettext("Read the orientation (a good minute), then pass the clearance test.")),
    link(gettext("Read the orientation"), `/robots/${robot.slug}/orientation/`, "button primary"),
  ];
}

/** Return the way to driving for somebody who is not signed in. */
function strangerParts(slug: string): Part[] {
  return [
    heading(gettext("Drive it yourself")),
    paragraph(gettext("Sign up, read the orientation, pass a short test, and wait your turn.")),
    link(gettext("Sign up"), `/robots/${slug}/drive/`, "button primary"),
    link(gettext("Sign in"), `/accounts/login/?next=/robots/${slug}/`, "button"),
    ...practiceLink(gettext("Try a simulator first")),
  ];
}

/** Return the link to the robot's simulator for practice; nothing if it has none. */
function practiceLink(text: string): Part[] {
  const href = document.getElementById("robot")?.dataset["practice"];
  return href ? [link(text, href, "button")] : [];
}

/** Ask for a turn on a simulator without an account. */
function practise(): void {
  document.querySelector<HTMLFormElement>("#practise")?.requestSubmit();
}

/** Return what somebody who is not signed in can do on a simulator for practice. */
function beforePractice({ robot, queue }: Snapshot, why: string): Part[] {
  const { slug, name, guest_s: seconds } = robot.practice ?? { slug: "", name: "", guest_s: null };
  if (seconds === null)
    return [
      heading(gettext("Practise here")),
      paragraph(gettext("People who have an account learn here to drive {name}. Nothing real moves.", { name })),
      link(gettext("Sign up"), `/accounts/signup/?next=/robots/${robot.slug}/`, "button primary"),
      link(gettext("Sign in"), `/accounts/login/?next=/robots/${robot.slug}/`, "button"),
    ];
  return [
    heading(gettext("Try it now")),
    paragraph(
      [
        gettext("Drive this simulator for {seconds} seconds, without an account. Nothing real moves.", { seconds }),
        ...(queue ? [queueSentence(queue)] : []),
      ].join(" "),
    ),
    button(gettext("Try it"), "practise", { style: "primary", why }),
    link(gettext("Drive {name} instead", { name }), `/robots/${slug}/drive/`, "button"),
  ];
}

/** Return what a guest can do after a turn on a simulator. */
function afterPractice(s: Snapshot, why: string): Part[] {
  const { robot } = s;
  const { slug, name } = robot.practice ?? { slug: "", name: "" };
  return [
    heading(gettext("Next: {name}", { name })),
    paragraph(gettext("Sign up, read for a good minute, pass a short test, and drive {name}.", { name })),
    link(gettext("Drive {name}", { name }), `/robots/${slug}/drive/`, "button primary"),
    button(gettext("Try it again"), isSoon(s) ? "take" : "join", { why }),
  ];
}

/** Return how the last turn ended, what it cost and what is next, if the snapshot still tells it. */
function ended({ me, robot }: Snapshot, now: number): Part[] {
  const end = me.last_end;
  if (!end) return [];
  const news = now - end.ended_ms < LATELY_MS;
  const rest = news && !robot.practice ? ` ${translate(end.credited)} ${translate(end.next)}` : ""; // practice costs nothing
  const ask = [
    paragraph(gettext("What did you find? Others read it."), "more"),
    link(gettext("Write in the operator's log"), `/turns/${end.turn}/`, "button primary"),
  ];
  return [
    heading(news ? gettext("Your turn is over") : gettext("Your last turn")),
    paragraph(`${gettext("It ended at {time}.", { time: timeOfDay(end.ended_ms) })} ${translate(end.why)}${rest}`),
    ...(end.written ? [] : ask),
  ];
}

/** Return the panel of a robot that nobody drives. */
function jobsOnly({ me, robot }: Snapshot): Part[] {
  const jobs = `/robots/${robot.slug}/jobs/`;
  const here = me.can.ask && document.getElementById("asking") !== null; // its console has a part for this
  return [
    heading(gettext("It works by itself")),
    paragraph(
      me.can.ask
        ? gettext("Nobody drives this robot. Ask it for something, and watch.")
        : gettext("Nobody drives this robot. It takes jobs from people with clearance."),
    ),
    link(me.can.ask ? gettext("Ask for a job") : gettext("See its jobs"), here ? "#asking" : jobs, "button primary"),
    ...(here ? [link(gettext("All jobs"), jobs)] : []),
  ];
}
