/** Everybody's jobs of one kind: ask for one, one's own place and wait, how it ended, and the list of those that wait. */
import { html } from "lit-html";
import { byId, say } from "../kit/dom.ts";
import { button, drawParts, link, type Part } from "../kit/render.ts";
import { gettext, translate } from "../kit/text.ts";
import type { RobotPage } from "../page/robot_page.ts";
import { Jobs, type OwnJob } from "../queue/jobs.ts";
import { jobSentence, SUSPENDED, waitWords } from "../queue/waits.ts";
import type { JobInfo } from "../socket/messages.ts";

/** A kind of job: its noun, and the word for a job that is done (default: "reached"). */
export interface JobName {
  noun: string;
  done?: string;
}
/**
 * The words for a kind of job. `how`: how people ask for one; `where`: the place that its values name; `others`: other
 * kinds of jobs in the same list.
 */
export interface JobWords extends JobName {
  kind: string;
  how: string;
  where(values: Record<string, number | string>, kind: string): string;
  others?: Record<string, JobName>;
}

export class JobPanel {
  /** The open jobs in the order in which they will be served, and whether they are the viewer's. */
  open: { job: JobInfo; own: boolean }[] = [];
  private jobs: Jobs;
  private asking = false;
  private heard: readonly JobInfo[] | null = null;
  private followed = new Set<number>(); // the own jobs that were open at the last answer
  private fresh = 0; // the own job whose place in the queue has still to be told; 0: none
  private waiting = new Set<number>(); // the own jobs that were seen waiting, so that their begin is told

  constructor(
    private page: RobotPage,
    private words: JobWords,
    private changed: () => void,
  ) {
    const token = byId("asking-form").querySelector<HTMLInputElement>("[name=csrfmiddlewaretoken]")?.value ?? "";
    this.jobs = new Jobs(page.slug, token, () => this.follow());
    byId("asked-do").addEventListener("click", (event) => {
      if ((event.target as HTMLElement).closest("[data-do=cancel]")) void this.cancel();
    });
    void this.jobs.refresh();
  }

  /** Why nobody here can ask now; empty if they can. */
  whyNot(): string {
    const s = this.page.snapshot;
    if (!s || this.page.live.lost) return gettext("The connection is lost; the page tries to connect again.");
    if (s.replay) return gettext("This is a recording.");
    if (!s.me.can.ask)
      return s.me.signed_in
        ? gettext("Pass the clearance test of this robot first.")
        : gettext("Sign in to ask for a {noun}.", { noun: this.words.noun });
    return this.asking ? gettext("Your {noun} is on its way to the portal.", { noun: this.words.noun }) : "";
  }

  /** Ask for a job, and say why if it is refused. Resolves to whether it waits now. */
  async ask(values: Record<string, number | string>, kind = this.words.kind): Promise<boolean> {
    if (this.whyNot()) {
      this.page.refuse(() => this.whyNot());
      return false;
    }
    this.page.settle();
    this.asking = true;
    this.page.draw();
    const refused = await this.jobs.ask(kind, values, this.page.seen);
    this.asking = false;
    if (refused) this.page.refuse(() => refused);
    else this.fresh = this.jobs.own[0]?.id ?? 0;
    this.page.draw();
    return !refused;
  }

  private named(kind: string): JobName {
    return this.words.others?.[kind] ?? this.words;
  }

  private async cancel(): Promise<void> {
    const job = this.current();
    this.page.settle();
    const refused = job ? await this.jobs.cancel(job) : "";
    if (refused) this.page.refuse(() => refused);
  }

  /** The own jobs were read: say how those ended that were open before. */
  private follow(): void {
    for (const job of this.jobs.own) if (!job.open && this.followed.has(job.id)) this.page.notice(ended(job, this.named(job.kind)), "info");
    this.followed = new Set(this.jobs.own.filter(({ open }) => open).map(({ id }) => id));
    this.draw();
  }

  /** Return the own job to show: the open one that is served first, otherwise the newest. */
  private current(): OwnJob | undefined {
    const open = this.open.find(({ own }) => own);
    return (open && this.jobs.mine(open.job.id)) ?? this.jobs.own.find((job) => job.open) ?? this.jobs.own[0];
  }

  draw(): void {
    const s = this.page.snapshot;
    if (!s) return;
    if (s.jobs !== this.heard) {
      this.heard = s.jobs;
      this.jobs.update(s.jobs);
    }
    this.open = s.jobs
      .filter(({ kind }) => kind === this.words.kind || this.words.others?.[kind])
      .map((job) => ({ job, own: this.jobs.mine(job.id) !== undefined }));
    const job = this.current();
    const about = this.about(job);
    say(byId("asked"), about);
    drawParts(byId("asked-do"), this.actions(job));
    if (this.fresh && this.open.some(({ job: { id } }) => id === this.fresh)) {
      this.fresh = 0;
      this.page.notice(about, "info");
    }
    this.tellBegun();
    this.list();
    this.changed();
  }

  private tellBegun(): void {
    for (const { job } of this.open.filter(({ own }) => own)) {
      if (job.state === "waiting") this.waiting.add(job.id);
      else if (this.waiting.delete(job.id)) this.page.notice(this.begun(job.kind), "info");
    }
  }

  private begun(kind: string): string {
    const { noun, done } = this.named(kind);
    return done ? gettext("The robot carries out your {noun}.", { noun }) : gettext("The robot is on its way to your {noun}.", { noun });
  }

  private about(job: OwnJob | undefined): string {
    const { how } = this.words,
      { noun } = this.named(job?.kind ?? this.words.kind);
    const s = this.page.snapshot!;
    if (!job && !s.me.can.ask) return this.whyNot();
    if (!job) return `${how} ${gettext("You need not wait here: the {noun}'s own page tells how it ended.", { noun })}`;
    if (!job.open) return `${ended(job, this.named(job.kind))} ${gettext("You can ask for another.")}`;
    const told = this.open.find(({ job: { id } }) => id === job.id)?.job;
    if (!told) return `${gettext("Your {noun} was taken.", { noun })}${s.suspended ? ` ${SUSPENDED}` : ""}`;
    if (told.state === "running") return this.begun(job.kind);
    const why = [job.reason, told.wait_s === null ? s.robot.why : ""].filter(Boolean);
    return [jobSentence(noun, told.ahead, told.wait_s, s.suspended), ...why.map(translate)].join(" ");
  }

  private actions(job: OwnJob | undefined): Part[] {
    if (!job) return [];
    const { noun } = this.named(job.kind);
    const page = link(gettext("Page of your {noun}", { noun }), job.url);
    return job.open ? [button(gettext("Cancel my {noun}", { noun }), "cancel"), page] : [page];
  }

  private list(): void {
    const parts = this.open.map(({ job, own }): Part => {
      const state =
        job.state === "running"
          ? gettext("on its way")
          : this.page.snapshot?.suspended
            ? gettext("waits for staff")
            : waitWords(job.wait_s);
      const text = `${this.words.where(job.args, job.kind)}: ${state}${own ? ` ${gettext("(yours)")}` : ""}`;
      return { key: job.id, template: html`<li class=${own ? "own" : ""}><b>${job.ahead}</b><span>${text}</span></li>` };
    });
    drawParts(byId("goals"), parts);
  }
}

function ended(job: OwnJob, { noun, done = gettext("reached") }: JobName): string {
  const words: Record<string, string> = {
    done: gettext("Your {noun} was {done}.", { noun, done }),
    cancelled: gettext("Your {noun} was cancelled.", { noun }),
    failed: gettext("Your {noun} was not {done}.", { noun, done }),
    unknown: gettext("Nobody knows whether your {noun} was {done}.", { noun, done }),
  };
  const why = job.reason && job.reason !== "Cancelled." ? ` ${translate(job.reason)}` : "";
  return `${words[job.state] ?? translate(job.label)}${why}`;
}
