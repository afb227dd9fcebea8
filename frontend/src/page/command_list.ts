/** The list of commands with their stages, newest first. */
import { html, nothing, type TemplateResult } from "lit-html";
import { draw, drawParts, type Part } from "../kit/render.ts";
import { gettext, translate } from "../kit/text.ts";
import type { CommandInfo } from "../socket/messages.ts";
import { FINAL, COMMAND_LABELS, laterStage, SETTING_KINDS, stageOf } from "../socket/stages.ts";

const LOST_MS = 3000; // for a command that the process behind an earlier socket still carries out
const NOT_ARRIVED = gettext("This did not arrive: the connection broke off. Try it again.");
const GAVE_WAY = ["Replaced", "Interrupted"] as const; // to a newer target, to somebody else: no fault
const GOOD = ["accepted", "sent", "acknowledged", "completed"];

/** Return by what a command is known in the list. */
function keyOf({ grant, seq }: Pick<CommandInfo, "grant" | "seq">): string {
  return `${grant}/${seq}`;
}

export class CommandList {
  private rows = new Map<string, CommandInfo>();
  private sent = new Map<string, number>(); // a command that this page has sent stands after that id, until it has its own
  private waiting = new Map<string, (c: CommandInfo) => void>();

  private readonly list: HTMLElement;
  private readonly live: HTMLElement;

  private readonly last: HTMLElement | null;

  /** `live`: where the end of a command is announced to screen readers; `last`: where the newest one is shown in one line. */
  constructor(list: HTMLElement, live: HTMLElement, last: HTMLElement | null = null) {
    [this.list, this.live, this.last] = [list, live, last];
  }

  /** Forget everything: a recording is shown from another moment on. */
  clear(): void {
    this.rows.clear();
    this.sent.clear();
  }

  /** Show what a snapshot contains; the end of a command may come with it, before its own message. */
  reset(commands: CommandInfo[]): void {
    const ended: CommandInfo[] = [];
    for (const c of commands) {
      const known = this.rows.get(keyOf(c)),
        now = laterStage(known, c);
      this.rows.set(keyOf(c), now);
      if (known && !FINAL.has(known.state) && FINAL.has(now.state)) ended.push(now);
    }
    this.draw();
    for (const c of ended) this.tellEnd(c);
  }

  /** Show a stage that arrived; a final stage of the server's is never replaced by an older message. */
  update(c: CommandInfo): void {
    const key = keyOf(c);
    const known = this.rows.get(key);
    if (known && FINAL.has(known.state) && (known.id !== 0 || c.id === 0)) return;
    const now = { ...known, ...c };
    this.rows.set(key, now);
    if (!known && c.id === 0) this.sent.set(key, Math.max(0, ...[...this.rows.values()].map(({ id }) => id)) + 0.5);
    this.draw();
    if (FINAL.has(c.state)) this.tellEnd(now);
  }

  private tellEnd(c: CommandInfo): void {
    this.live.textContent = say(c);
    this.waiting.get(keyOf(c))?.(c);
    this.waiting.delete(keyOf(c));
  }

  /** Reject what was sent over an earlier socket than number `opened`, over which a snapshot has come, some seconds before `at`. */
  lost(opened: number, at: number): void {
    for (const c of this.rows.values())
      if (c.id === 0 && c.state === "sending" && (c.over ?? opened) < opened && at - c.at_ms > LOST_MS)
        this.update({ ...c, state: "rejected", reason: NOT_ARRIVED, at_ms: at });
  }

  /** Show that the server refused that command of this grant, and why. */
  refuse(grant: number, seq: number, reason: string, at: number): void {
    const known = this.rows.get(keyOf({ grant, seq })),
      kind = known?.kind ?? "";
    if (known?.id) return; // another page's command has that number; the row tells of that one
    this.update({ id: 0, seq, grant, kind, state: "rejected", reason, at_ms: at, result: {} });
  }

  /** Return the motion of this grant that runs or waits, also one that was only just sent; those `beside` a motion do not count. */
  motion(grant: number, beside: ReadonlySet<string>): CommandInfo | undefined {
    return [...this.rows.values()].find((c) => c.grant === grant && !FINAL.has(c.state) && !beside.has(c.kind));
  }

  /** Return the newest command of that kind, also one that was only just sent; undefined if none is known. */
  newest(kind: string): CommandInfo | undefined {
    return this.inOrder().find((c) => c.kind === kind);
  }

  /** Call `then` once, when that command of this grant has ended. */
  whenEnded(grant: number, seq: number, then: (c: CommandInfo) => void): void {
    this.waiting.set(keyOf({ grant, seq }), then);
  }

  /** Whether that command of this grant has ended. */
  ended(grant: number, seq: number): boolean {
    const known = this.rows.get(keyOf({ grant, seq }));
    return known !== undefined && FINAL.has(known.state);
  }

  /** Return all that are known, the newest first. */
  private inOrder(): CommandInfo[] {
    const place = (c: CommandInfo): number => c.id || (this.sent.get(keyOf(c)) ?? 0);
    return [...this.rows.values()].sort((a, b) => place(b) - place(a) || b.seq - a.seq);
  }

  private draw(): void {
    const newest = this.inOrder().slice(0, 8);
    for (const [key, c] of this.rows) if (this.rows.size > 40 && !newest.includes(c) && this.rows.delete(key)) this.sent.delete(key);
    drawParts(this.list, newest.map(row));
    if (this.last) drawLast(this.last, newest[0]);
  }
}

/** What the list says of a command: the style of its row, the end of its way, and why. */
interface Said {
  mark: string;
  chip: string;
  why: string;
}

export function saidOf(c: CommandInfo): Said {
  const gaveWay = GAVE_WAY.find((word) => c.reason.startsWith(word));
  const mark = FINAL.has(c.state) && c.state !== "completed" && !gaveWay ? "bad" : c.state;
  const why = c.reason || c.result?.note || (c.state === "completed" && c.result?.stable === false ? `Picture: ${c.result.verdict}.` : "");
  const chip = gaveWay === "Replaced" ? gettext("Replaced") : gaveWay ? gettext("Interrupted") : stageOf(c.kind, c.state);
  return { mark, chip, why: translate(why) };
}

function stepsOf(c: CommandInfo): TemplateResult {
  const reached = GOOD.indexOf(c.state);
  return html`<span class="steps" aria-hidden="true">${GOOD.map((_, i) => html`<i class=${i <= reached ? "on" : ""}></i>`)}</span>`;
}

function row(c: CommandInfo): Part {
  const { mark, chip, why } = saidOf(c);
  const template = html`<li class=${`command ${mark}`} data-state=${c.state}><b>${COMMAND_LABELS[c.kind] ?? c.kind}</b>${stepsOf(c)}<span class="chip">${chip}</span><p ?hidden=${!why}>${why}</p>${progress(c)}</li>`;
  return { key: keyOf(c), template };
}

/** Show a command in one line; nothing before the first. */
function drawLast(box: HTMLElement, c: CommandInfo | undefined): void {
  const { mark = "", chip = "", why = "" } = c ? saidOf(c) : {};
  box.className = `last-command command ${mark}`.trim();
  const name = c ? (COMMAND_LABELS[c.kind] ?? c.kind) : "";
  box.title = c ? `${name}: ${chip}. ${why}`.trim() : "";
  draw(
    box,
    c ? html`<b>${name}</b> ${stepsOf(c)} <span class="chip">${chip}</span> <span class="reason">${mark === "bad" ? why : ""}</span>` : "",
  );
}

/** The progress of a long command while it runs; an unknown share is a bar without a value. */
function progress(c: CommandInfo): TemplateResult {
  const known = c.progress?.at_ms !== undefined && !FINAL.has(c.state);
  const { share = null, text: told = "" } = c.progress ?? {};
  const text = translate(told);
  return html`<div class="progress" ?hidden=${!known}><progress value=${share ?? nothing} aria-label=${text || gettext("Progress")}></progress><span>${text}</span></div>`;
}

function say(c: CommandInfo): string {
  const name = COMMAND_LABELS[c.kind] ?? c.kind;
  const verdict = c.result?.verdict,
    reason = translate(c.reason);
  if (c.state === "completed" && SETTING_KINDS.has(c.kind)) return gettext("{name}: done.", { name });
  if (c.state === "completed" && !verdict) return gettext("{name}: done, the picture is there.", { name });
  if (c.state === "completed") return gettext("{name}: done, the picture is {verdict}.", { name, verdict: translate(verdict ?? "") });
  return c.reason.startsWith("Interrupted") ? `${name}: ${reason}` : `${name}: ${stageOf(c.kind, c.state)}. ${reason}`;
}
