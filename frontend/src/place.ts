/** The panel that says whose turn it is and what you can do about it. */
import { type Part, show } from "./parts.ts";
import type { Snapshot } from "./protocol.ts";
import { clock, span } from "./words.ts";

type Send = (message: object) => boolean;

export class Place {
  private title = document.title;
  private offered = false;

  constructor(private box: HTMLElement, private live: HTMLElement, private send: Send) {
    box.addEventListener("click", (event) => {
      const action = (event.target as HTMLElement).closest<HTMLElement>("[data-do]")?.dataset["do"];
      if (action) this.send({ t: action });
    });
  }

  /** Draw the panel; called at each snapshot and each second. */
  draw(s: Snapshot, now: number, up: boolean): void {
    show(this.box, this.parts(s, now).map((part) => (part.do ? { ...part, disabled: !up } : part)));
  }

  private parts(s: Snapshot, now: number): Part[] {
    const slug = s.robot.slug;
    const { me } = s;
    if (me.operating && s.turn) {
      const left = s.turn.until_ms ? (s.turn.until_ms - now) / 1000 : 0;
      return [
        { tag: "h2", text: s.turn.staff ? "Maintenance turn" : "You drive" },
        { tag: "p", class: "timer", text: clock(left), timer: true },
        { tag: "p", text: s.turn.extra ? "Nobody waits, so your turn goes on." : "left in your turn" },
        ...(s.turn.staff ? [] : [{ tag: "button", do: "leave", text: "End my turn" } as Part]),
      ];
    }
    if (!me.signed_in)
      return [
        { tag: "h2", text: "Drive it yourself" },
        { tag: "p", text: "Sign up, read the orientation, pass a short test, and wait your turn." },
        { tag: "a", href: `/accounts/signup/?next=/robots/${slug}/`, text: "Sign up", class: "button primary" },
        { tag: "a", href: `/accounts/login/?next=/robots/${slug}/`, text: "Sign in", class: "button" },
      ];
    if (!me.cleared)
      return [
        { tag: "h2", text: "Two steps to go" },
        { tag: "p", text: "Read the orientation (three minutes), then pass the clearance test." },
        { tag: "a", href: `/robots/${slug}/orientation/`, text: "Read the orientation", class: "button primary" },
      ];
    const t = me.ticket;
    if (t?.state === "offered") {
      const left = t.offer_until_ms ? (t.offer_until_ms - now) / 1000 : 0;
      return [
        { tag: "h2", text: "It is your turn" },
        { tag: "p", class: "timer", text: clock(left), timer: true },
        { tag: "button", do: "accept", text: "Take control", class: "primary" },
        { tag: "button", do: "leave", text: "Not now" },
      ];
    }
    if (t?.state === "waiting")
      return [
        { tag: "h2", text: t.ahead === 0 ? "You are next" : `${t.ahead} before you` },
        {
          tag: "p",
          text: t.wait_s === null ? "The wait is not known: the robot is out of order. Your place is kept."
            : t.wait_s[1] < 10 ? "Any moment now." : `About ${span(t.wait_s[0])} to ${span(t.wait_s[1])}.`,
        },
        { tag: "p", class: "quiet", text: "You may look around; title and sound tell you when it is your turn." },
        { tag: "button", do: "leave", text: "Leave the queue" },
      ];
    const parts: Part[] = [
      { tag: "h2", text: "Drive it yourself" },
      { tag: "p", text: s.queue === 0 ? "Nobody waits." : s.queue === 1 ? "One person waits." : `${s.queue} people wait.` },
      { tag: "button", do: "join", text: "Join the queue", class: "primary" },
    ];
    if (me.last_turn)
      parts.unshift(
        { tag: "h2", text: "Your turn is over" },
        { tag: "p", text: "What did you find? Others read it." },
        { tag: "a", href: `/turns/${me.last_turn}/`, text: "Write in the operator's log", class: "button primary" },
      );
    return parts;
  }

  /** Title, sound and a spoken word when the offer comes. */
  announce(s: Snapshot): void {
    const offered = s.me.ticket?.state === "offered";
    if (offered && !this.offered) {
      this.live.textContent = `It is your turn on ${s.robot.name}. Take control within the time shown.`;
      chime();
    }
    this.offered = offered;
    const ticket = s.me.ticket;
    document.title = offered ? `▶ Your turn! ${this.title}`
      : s.me.operating ? `● Driving ${this.title}`
      : ticket?.state === "waiting" ? `(${ticket.ahead + 1}) ${this.title}` : this.title;
  }
}

function chime(): void {
  try {
    const audio = new AudioContext();
    for (const [i, frequency] of [660, 880].entries()) {
      const tone = audio.createOscillator();
      const volume = audio.createGain();
      const at = audio.currentTime + i * 0.22;
      tone.frequency.value = frequency;
      volume.gain.setValueAtTime(0.15, at);
      volume.gain.exponentialRampToValueAtTime(0.001, at + 0.4);
      tone.connect(volume).connect(audio.destination);
      tone.start(at);
      tone.stop(at + 0.4);
    }
  } catch {
    // a browser without sound still shows title and panel
  }
}
