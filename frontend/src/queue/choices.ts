/** Choices of the person that the portal stores: whether this browser, or an e-mail, tells them of their turn. */
import { isLate, request } from "../kit/request.ts";
import { gettext, translate } from "../kit/text.ts";
import { UNSENT } from "./person_socket.ts";

const UNANSWERED = gettext("There was no answer, so whether that was stored is not known. Press again when the connection is back.");

export interface Answer {
  ok: boolean;
  text: string;
}

/** Send a choice to one of the person's addresses. `text` says what is now, or went wrong. */
export async function send(address: string, token: string, fields: Record<string, string>): Promise<Answer> {
  const body = new URLSearchParams({ ...fields, csrfmiddlewaretoken: token });
  try {
    const answer = await request(address, { method: "POST", body, headers: { Accept: "application/json" }, redirect: "manual" });
    if (answer.type === "opaqueredirect") return { ok: false, text: gettext("You are signed out. Sign in again.") };
    const { ok, text } = (await answer.json()) as Answer;
    return { ok, text: translate(text) };
  } catch (error) {
    return { ok: false, text: isLate(error) ? UNANSWERED : UNSENT };
  }
}

/** Whether an e-mail, too, tells the person of their turn. */
export class MailChoice {
  private busy = false;
  private token: string;
  /** Whether there is a confirmed address, so that there is anything to choose. */
  readonly offered: boolean;
  on: boolean;

  /** `stored`: "on" or "off"; empty: the person has no confirmed address. */
  constructor(stored: string, token: string) {
    this.offered = stored !== "";
    this.on = stored === "on";
    this.token = token;
  }

  /** Switch it on or off. Resolves to a sentence that says what is now. */
  async press(): Promise<string> {
    if (this.busy) return "";
    this.busy = true;
    const { ok, text } = await send("/me/choices/", this.token, { do: "mail", on: this.on ? "" : "on" });
    this.busy = false;
    if (ok) this.on = !this.on;
    return text;
  }
}
