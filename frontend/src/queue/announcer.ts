/** Messages for a person who looks elsewhere: title, icon, sound, vibration, notification, screen reader. */
import { say } from "../kit/dom.ts";
import { storage } from "../kit/storage.ts";
import { gettext, translate } from "../kit/text.ts";
import type { Notices } from "./notices.ts";
import type { QueuePlace } from "./person_socket.ts";

const MOMENTS_S = [60, 20, 10];
/** The action of the bar's button for the sound, as in its `data-do`. */
export const SOUND_ACTION = "ask-sound";
const READY_MS = 400; // a browser that plays begins within this time

export class Announcer {
  private title = document.title;
  private icon = document.querySelector<HTMLLinkElement>("link[rel=icon]");
  private calmIcon = this.icon?.href ?? "";
  private audio: AudioContext | null = null;
  private last = new Map<string, number>();
  private known = new Set<string>();
  private wantsSound = false;
  /** Whether the browser has played on this page. */
  ran = false;
  private asked = false; // whether the sound's button was pressed since the browser last played
  private polite: HTMLElement;
  private assertive: HTMLElement;
  private chimes = 0; // a later chime replaces one that still waits
  private open: (place: QueuePlace) => void;
  private notices: Pick<Notices, "show">;

  constructor(polite: HTMLElement, assertive: HTMLElement, open: (place: QueuePlace) => void, notices: Pick<Notices, "show">) {
    this.polite = polite;
    this.assertive = assertive;
    this.open = open;
    this.notices = notices;
    for (const name of ["pointerdown", "pointerup", "keydown", "pageshow", "focus"])
      addEventListener(name, ({ target }) => this.ready(target), { capture: true, passive: true });
  }

  get sound(): boolean {
    return storage.get("sound") !== "off";
  }

  set sound(on: boolean) {
    storage.set("sound", on ? "on" : "off");
    if (on) this.chime();
  }

  /** Whether the browser would not play now: nobody has pressed anything, or it has paused the page's sound. */
  get paused(): boolean {
    return this.sound && this.audio?.state !== "running";
  }

  /** Take a press of the sound's button: resume a paused sound; if that has not helped before, switch it off. */
  press(): void {
    const on = !this.sound || (this.paused && !this.asked);
    this.asked = on;
    this.sound = on;
  }

  /** Announce the news of these places, the most urgent first; called at each change and every half second. */
  tell(places: readonly QueuePlace[], now: number, own: string): void {
    const [first] = places;
    if (this.audio?.state === "running") [this.ran, this.asked] = [true, false];
    this.wantsSound = places.some((p) => p.state === "waiting" || p.state === "offered");
    const title = mark(first, own) + this.title;
    if (document.title !== title) document.title = title;
    const icon = first?.state === "offered" || first?.state === "missed" ? (this.icon?.dataset["turn"] ?? "") : this.calmIcon;
    if (this.icon && icon && this.icon.href !== new URL(icon, location.href).href) this.icon.href = icon;
    for (const place of places) this.news(place, now);
  }

  private news(place: QueuePlace, now: number): void {
    const key = `${place.state}-${place.ticket}-${place.state === "offered" ? place.until_ms : ""}`;
    const left = ((place.kept_until_ms ?? place.until_ms ?? now) - now) / 1000;
    if (!this.known.has(key)) {
      this.known.add(key);
      if (place.state === "offered") this.offer(place, key, left);
      if (place.state === "missed") say(this.polite, gettext("You missed your turn on {name}. You can join again.", { name: place.name }));
      if (place.state === "ended") this.ended(place, key);
    }
    if (place.state !== "offered" && place.state !== "operating") return;
    this.idle(place, now);
    const before = this.last.get(key) ?? Infinity;
    this.last.set(key, left);
    const moment = MOMENTS_S.filter((at) => left <= at && at < before && left > 0).at(-1);
    if (moment === undefined || before === Infinity) return;
    const values = { seconds: moment, name: place.name };
    const words =
      place.state === "offered"
        ? gettext("{seconds} seconds left to take control of {name}.", values)
        : gettext("{seconds} seconds left in your turn on {name}.", values);
    say(moment === 60 ? this.polite : this.assertive, words);
  }

  /** Announce once that the turn ends soon because nothing is done; again only after something was done. */
  private idle(place: QueuePlace, now: number): void {
    const key = `idle-${place.ticket}`;
    if (!place.idles) this.known.delete(key);
    else if (!this.known.has(key)) {
      this.known.add(key);
      const left = Math.max(0, Math.ceil(((place.idle_ms ?? now) - now) / 1000));
      const words = gettext("Your turn on {name} ends in {seconds} seconds, because nothing was done.", {
        name: place.name,
        seconds: left,
      });
      say(this.assertive, `${words} ${gettext("Press I'm here, or give a command.")}`);
      this.chime();
      if (document.hidden || !document.hasFocus()) this.notify(place, `${key}-${place.idle_ms}`, words, gettext("Say that you are there."));
    }
  }

  private ended(place: QueuePlace, key: string): void {
    const { name } = place,
      why = translate(place.end?.why ?? "");
    const words =
      place.turn === null ? gettext("You lost your place for {name}", { name }) : gettext("Your turn on {name} is over", { name });
    say(this.polite, `${words}. ${why}`);
    if (storage.get("told") === key) return;
    storage.set("told", key);
    if (document.hidden || !document.hasFocus()) this.notify(place, key, words, why);
  }

  private offer(place: QueuePlace, key: string, left: number): void {
    const { name } = place,
      seconds = Math.max(0, Math.ceil(left));
    say(this.assertive, gettext("It is your turn on {name}. You have {seconds} seconds to take control.", { name, seconds }));
    if (storage.get("told") === key) return; // another page of this browser told it
    this.chime(() => storage.set("told", key));
    if (touched() && "vibrate" in navigator) navigator.vibrate([200, 100, 200]);
    if (document.hidden || !document.hasFocus())
      this.notify(
        place,
        `turn-${place.robot}`,
        gettext("It is your turn on {name}", { name }),
        gettext("Take control before the offer ends."),
      );
  }

  private notify(place: QueuePlace, tag: string, title: string, body: string): void {
    const notice = { title, body, tag, icon: this.calmIcon, url: `/robots/${place.robot}/` };
    this.notices.show(notice, () => this.open(place));
  }

  /** Prepare the sound for a chime; a press of the sound's button is left to that button. */
  private ready(target: EventTarget | null): void {
    const own = target instanceof Element && target.closest(`[data-do="${SOUND_ACTION}"]`) !== null;
    if (this.wantsSound && !own && touched()) this.prime();
  }

  /** Open or resume the audio; browsers allow that only after a press on the page. */
  private prime(): void {
    if (!this.sound) return;
    try {
      this.audio ??= new AudioContext();
      if (this.audio.state !== "running") this.audio.resume().catch(() => undefined);
    } catch {
      // a browser without sound still shows everything
    }
  }

  /** Play two notes at once or not at all; `played` is called if the browser plays them. */
  private chime(played: () => void = () => undefined): void {
    if (!this.sound || !touched()) return;
    this.prime();
    const chime = ++this.chimes;
    const now = (): void => {
      if (!this.audio || this.paused || chime !== this.chimes) return; // a paused audio would play it at some later time
      play(this.audio);
      played();
    };
    if (this.paused) setTimeout(now, READY_MS);
    else now();
  }
}

/** Return whether somebody has pressed anything on this page; not every browser knows. */
function touched(): boolean {
  return (navigator as Partial<Navigator>).userActivation?.hasBeenActive ?? false;
}

function play(audio: AudioContext): void {
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
}

function mark(place: QueuePlace | undefined, own: string): string {
  if (place?.state === "offered") return `▶ ${gettext("Your turn!")} `;
  if (place?.idles) return `! ${gettext("Your turn ends soon")} `;
  if (place?.state === "operating")
    return place.robot === own ? `● ${gettext("Driving")} ` : `● ${gettext("Your turn on {name} runs!", { name: place.name })} `;
  if (place?.state === "missed") return `! ${gettext("Missed turn")} `;
  if (place?.state === "ended") return place.turn === null ? `! ${gettext("Place lost")} ` : `! ${gettext("Turn over")} `;
  return place ? `(${place.ahead + 1}) ` : "";
}
