/** The signed-in person's connection, one per page: their places, by a socket or by a request every ten seconds. */
import { isLate, openSocket, request } from "../kit/request.ts";
import { gettext, translate } from "../kit/text.ts";
import type { EndReason } from "../socket/messages.ts";

export interface QueuePlace {
  state: "offered" | "operating" | "missed" | "ended" | "waiting";
  ticket: number;
  robot: string;
  name: string;
  simulated?: boolean;
  ahead: number;
  away: boolean;
  until_ms: number | null;
  kept_until_ms: number | null;
  ended_ms: number | null;
  wait_s: [number, number] | null;
  /** When the turn ends unless something is done; null while nobody waits for it. */
  idle_ms: number | null;
  /** Whether `idle_ms` is soon; this page judges it. */
  idles?: boolean;
  /** Of a place that is over: why, what it cost, and what is next. `turn`: the turn's number, if the place became a turn. */
  end: EndReason | null;
  turn: number | null;
}
export type PlaceAction = "join" | "leave" | "accept" | "stay" | "dismiss";
interface Places {
  t: "places";
  now_ms: number;
  places: QueuePlace[];
}
/** A request that waits for its answer over the socket. */
interface PendingRequest {
  what: PlaceAction;
  robot: string;
  repeated: boolean; // without the socket, in vain
  answered(text: string): void;
}
type Heard = Places | { t: "pulse"; now_ms: number } | { t: "answer"; to: string; robot: string; ok: boolean; text: string };

const SIGNED_OUT = 4401;
const DEAD_MS = 50_000; // the server says something every 20 s
const LOOK_MS = 5000; // or if it does not answer when it is asked: the device may have slept
const POLL_MS = 10_000;
const ANSWER_MS = 4000;
export const UNSENT = gettext("That could not be sent: there is no connection. Try again when it is back.");
export const UNANSWERED = gettext(
  "There was no answer, so whether that was done is not known. This page shows it when the connection is back.",
);

const WARN_MS = 20_500; // the server tells again 20 s before

/**
 * Return whether the turn ends soon because nothing is done in it, and not before because its page is closed. `toldMs`:
 * when the server said so, because an earlier message may not be true any more.
 */
export function isIdle(p: QueuePlace, toldMs: number): boolean {
  return p.state === "operating" && p.kept_until_ms === null && p.idle_ms !== null && p.idle_ms - toldMs <= WARN_MS;
}

/** Return the places without offers that are past their end; the server sends the result within two seconds. */
export function currentPlaces(places: readonly QueuePlace[], now: number): QueuePlace[] {
  return places.filter((p) => !(p.state === "offered" && p.until_ms !== null && p.until_ms <= now));
}

/**
 * Return the places for the turn bar, the most urgent first. The page of the robot `own` shows a turn there itself, and how it
 * ended, but not that it ends soon because nothing is done. While somebody drives there, what can wait is not shown: the bar
 * would take room from the pictures and controls.
 */
export function barPlaces(places: readonly QueuePlace[], own: string): QueuePlace[] {
  const drives = places.some((p) => p.robot === own && p.state === "operating");
  const hidden = (p: QueuePlace): boolean =>
    p.robot === own
      ? (p.state === "operating" && !p.idles) || (p.state === "ended" && p.turn !== null)
      : drives && !["offered", "operating"].includes(p.state);
  return places.filter((p) => !hidden(p)).sort((a, b) => Number(b.idles ?? false) - Number(a.idles ?? false));
}

export class PersonSocket {
  places: QueuePlace[] = [];
  /** Whether anything has arrived yet, and whether the person is still signed in. */
  known = false;
  over = false;
  private offset = 0;
  private socket: WebSocket | null = null;
  private tries = 0;
  private heard = 0;
  private looked = 0; // when the server was asked for the places and has not answered yet; 0: not asked
  private asked = 0;
  private waiting = new Set<PendingRequest>();
  private token: string;
  private changed: () => void;

  constructor(token: string, changed: () => void) {
    this.token = token;
    this.changed = changed;
    this.open();
    setInterval(() => this.watch(), 1000);
    for (const name of ["online", "pageshow", "focus"]) addEventListener(name, () => this.look());
    document.addEventListener("visibilitychange", () => document.hidden || this.look());
    document.addEventListener("farhand:place", () => this.look());
  }

  /** Server time, ms. */
  now(): number {
    return Date.now() + this.offset;
  }

  /**
   * Send the request. Resolves to what went wrong as a sentence, or to an empty text. What a socket has taken may arrive
   * as long as it is open, so it is not called unsent.
   */
  ask(what: PlaceAction, place: QueuePlace): Promise<string> {
    const { socket } = this;
    if (socket?.readyState !== WebSocket.OPEN) return this.post(what, place);
    return new Promise((resolve) => {
      const answered = (text: string): void => {
        this.waiting.delete(request);
        resolve(text);
      };
      const request: PendingRequest = { what, robot: place.robot, repeated: false, answered };
      this.waiting.add(request);
      socket.send(JSON.stringify({ t: "do", what, robot: place.robot, ticket: place.ticket }));
      setTimeout(() => this.waiting.has(request) && void this.repeat(request, place, socket), ANSWER_MS);
    });
  }

  private async repeat(request: PendingRequest, place: QueuePlace, socket: WebSocket): Promise<void> {
    const text = await this.post(request.what, place);
    if (text !== UNSENT) request.answered(text);
    else if (this.socket !== socket) request.answered(UNANSWERED);
    request.repeated = true;
  }

  /** Give up what a socket had taken that is no more; what has not been repeated yet will be. */
  private giveUp(): void {
    for (const request of this.waiting) if (request.repeated) request.answered(UNANSWERED);
  }

  /** Ask the server for the places again. */
  look(): void {
    if (this.over) return;
    if (this.socket?.readyState === WebSocket.OPEN) {
      this.socket.send('{"t":"look"}');
      this.looked ||= performance.now();
    } else if (this.socket?.readyState !== WebSocket.CONNECTING) this.open();
  }

  private open(): void {
    const socket = openSocket("/ws/me/");
    this.socket = socket;
    this.giveUp();
    this.heard = performance.now();
    this.looked = 0;
    socket.onmessage = (event) => this.take(JSON.parse(event.data as string) as Heard);
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.socket = null;
      if (event.code === SIGNED_OUT) {
        this.end();
        return;
      }
      const pause = Math.min(15_000, 500 * 2 ** this.tries++) * (0.5 + Math.random());
      setTimeout(() => this.socket === null && !this.over && this.open(), pause);
    };
  }

  private take(m: Heard): void {
    this.heard = performance.now();
    this.looked = 0;
    this.tries = 0;
    if (m.t === "answer") {
      // an answer that comes too late belongs to no request; a request that the server could not read is answered as "do"
      const meant = [...this.waiting].find(({ what, robot }) => m.to === "do" || (m.to === what && m.robot === robot));
      meant?.answered(m.text);
      return;
    }
    this.offset = m.now_ms - Date.now();
    if (m.t !== "places") return;
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send('{"t":"here"}');
    this.show(m.places, m.now_ms);
  }

  private show(places: QueuePlace[], told = 0): void {
    this.known = true;
    this.places = places.map((p) => ({ ...p, idles: isIdle(p, told) }));
    this.changed();
  }

  private end(): void {
    this.over = true;
    this.giveUp();
    this.show([]);
  }

  /** A socket without messages for long is closed; without one the page sends requests. */
  private watch(): void {
    if (this.over) return;
    const open = this.socket?.readyState === WebSocket.OPEN;
    const now = performance.now();
    if (open && (now - this.heard > DEAD_MS || (this.looked && now - this.looked > LOOK_MS))) {
      const old = this.socket;
      this.socket = null;
      old?.close();
      this.open();
    }
    if (!open && performance.now() - this.asked > POLL_MS) {
      this.asked = performance.now();
      void this.poll();
    }
  }

  private async poll(): Promise<void> {
    try {
      await this.read(await request("/me/places/", { headers: { Accept: "application/json" }, redirect: "manual" }));
    } catch {
      // no connection: asked again in ten seconds
    }
  }

  private async post(what: PlaceAction, place: QueuePlace): Promise<string> {
    const body = new URLSearchParams({ do: what, robot: place.robot, ticket: String(place.ticket), csrfmiddlewaretoken: this.token });
    try {
      const answer = await request("/me/places/", { method: "POST", body, headers: { Accept: "application/json" }, redirect: "manual" });
      return (await this.read(answer)) ?? UNSENT;
    } catch (error) {
      return isLate(error) ? UNANSWERED : UNSENT;
    }
  }

  /** Show the server's answer. Resolves to what went wrong, or to null for an answer that is not usable. */
  private async read(answer: Response): Promise<string | null> {
    if (answer.type === "opaqueredirect") {
      this.end();
      return gettext("You are signed out. Sign in again.");
    }
    if (!answer.ok) return null;
    const said = (await answer.json()) as Places & { text?: string };
    this.offset = said.now_ms - Date.now();
    this.show(said.places, said.now_ms);
    return translate(said.text ?? "");
  }
}
