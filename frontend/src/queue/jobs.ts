/** Jobs on a robot: ask for one, as a guest or signed in, follow the own ones, cancel one. */
import { request } from "../kit/request.ts";
import { gettext, translate } from "../kit/text.ts";
import type { JobInfo } from "../socket/messages.ts";

/** A job of the person at this browser. */
export interface OwnJob {
  id: number;
  kind: string;
  args: Record<string, number | string>;
  state: string;
  label: string;
  reason: string;
  open: boolean;
  url: string;
  asked_ms: number;
}

const UNCONFIRMED = gettext("The portal has not confirmed the request. Check your connection and try again.");

/** Return a token that nobody can guess; `crypto.randomUUID` would need HTTPS. */
const token = (): string => Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");

export class Jobs {
  /** The newest first; open ones, and those that ended within the hour. */
  own: OwnJob[] = [];
  private busy = false;
  private again = false;
  private known = false; // an answer has come
  private posted = 0; // the number of answered requests that changed something
  private readonly unanswered = new Map<string, string>(); // the token of the press for each request without an answer

  private readonly slug: string;
  private readonly token: string;
  private readonly changed: () => void;

  /** `token`: the form's token against forged requests; `changed` is called when `own` has changed. */
  constructor(slug: string, token: string, changed: () => void) {
    [this.slug, this.token, this.changed] = [slug, token, changed];
  }

  get address(): string {
    return `/robots/${this.slug}/jobs/`;
  }

  mine(id: number): OwnJob | undefined {
    return this.own.find((job) => job.id === id);
  }

  /** Read the own jobs again; one request at a time. */
  async refresh(): Promise<void> {
    this.again = this.busy;
    if (this.busy) return;
    this.busy = true;
    const { posted } = this;
    try {
      const answer = await this.request(this.address);
      const jobs = answer.ok ? ((await answer.json()) as { jobs: OwnJob[] }).jobs : this.own;
      this.known ||= answer.ok;
      if (posted === this.posted) this.own = jobs;
      else this.again = true; // the answer may be older than the request in between
      this.changed();
    } catch {
      // the next snapshot asks again
    }
    this.busy = false;
    if (this.again) void this.refresh();
  }

  /** Compare with the robot's open jobs: read the own ones again if one is missing or has begun, or if none was read yet. */
  update(open: readonly JobInfo[]): void {
    const states = new Map(open.map(({ id, state }) => [id, state]));
    if ((!this.known && !this.busy) || this.own.some((job) => job.open && states.get(job.id) !== job.state)) void this.refresh();
  }

  /**
   * Ask for a job; `seen`: when the picture on the page was taken (ms since 1970), 0 for none. Resolves to a sentence that
   * says why not; empty if it waits now. A repeated request without an answer in between is the same job.
   */
  ask(kind: string, values: Record<string, number | string>, seen = 0): Promise<string> {
    const named = Object.entries(values).map(([name, value]) => [`arg-${name}`, String(value)]);
    const body = new URLSearchParams([["kind", kind], ...named]);
    const asked = String(body);
    const press = this.unanswered.get(asked) ?? token();
    this.unanswered.set(asked, press);
    body.set("press", press);
    if (seen > 0) body.set("seen", String(Math.round(seen)));
    return this.post(this.address, body, () => this.unanswered.delete(asked));
  }

  /** Cancel an own job. Resolves to a sentence that says why not; empty if it is cancelled. */
  cancel(job: OwnJob): Promise<string> {
    return this.post(job.url, new URLSearchParams());
  }

  private request(address: string, more: RequestInit = {}): Promise<Response> {
    return request(address, { headers: { Accept: "application/json", "X-CSRFToken": this.token }, ...more });
  }

  private async post(address: string, body: URLSearchParams, answered?: () => void): Promise<string> {
    try {
      const answer = await this.request(address, { method: "POST", body });
      answered?.();
      const told = (await answer.json().catch(() => ({}))) as OwnJob & { error?: string };
      if (!answer.ok)
        return told.error
          ? translate(told.error)
          : answer.status === 403
            ? gettext("Reload the page, then try again.")
            : gettext("That did not work now; try again in a moment.");
      this.posted += 1;
      this.own = [told, ...this.own.filter(({ id }) => id !== told.id)];
      this.changed();
      return "";
    } catch {
      return UNCONFIRMED;
    }
  }
}
