/** The list of commands with their stages, newest first. */
import type { CommandInfo } from "../socket/protocol.ts";
import { say as write } from "../kit/dom.ts";
import { arrange } from "../kit/parts.ts";
import { FINAL, COMMAND_LABELS, laterStage, SETTING_KINDS, stageOf } from "../socket/stages.ts";

const LOST_MS = 3000; // for what an earlier socket's process still carries out
const NOT_ARRIVED = "This did not arrive: the connection broke off. Try it again.";
const GAVE_WAY = ["Replaced", "Interrupted"]; // to a newer target, to somebody else: no fault
const GOOD = ["accepted", "sent", "acknowledged", "completed"];

export class CommandList {
  private rows = new Map<string, CommandInfo>();
  private items = new Map<string, HTMLElement>();
  private sent = new Map<string, number>(); // what this page has sent comes after that id, until the server gives it one
  private waiting = new Map<string, (c: CommandInfo) => void>();

  private readonly list: HTMLElement;
  private readonly live: HTMLElement;

  constructor(list: HTMLElement, live: HTMLElement) {
    [this.list, this.live] = [list, live];
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
      const key = `${c.grant}/${c.seq}`;
      const known = this.rows.get(key), now = laterStage(known, c);
      this.rows.set(key, now);
      if (known && !FINAL.has(known.state) && FINAL.has(now.state)) ended.push(now);
    }
    this.draw();
    for (const c of ended) this.tellEnd(c);
  }

  /** Show a stage that arrived; a final stage of the server's is never replaced by an older message. */
  update(c: CommandInfo): void {
    const key = `${c.grant}/${c.seq}`;
    const known = this.rows.get(key);
    if (known && FINAL.has(known.state) && (known.id !== 0 || c.id === 0)) return;
    const now = { ...known, ...c };
    this.rows.set(key, now);
    if (!known && c.id === 0) this.sent.set(key, Math.max(0, ...[...this.rows.values()].map(({ id }) => id)) + 0.5);
    this.draw();
    if (FINAL.has(c.state)) this.tellEnd(now);
  }

  private tellEnd(c: CommandInfo): void {
    const key = `${c.grant}/${c.seq}`;
    this.live.textContent = say(c);
    this.waiting.get(key)?.(c);
    this.waiting.delete(key);
  }

  /** End what was sent over a socket before number `opened`, which has told what the server knows, a while ago. */
  lost(opened: number, at: number): void {
    for (const c of this.rows.values())
      if (c.id === 0 && c.state === "sending" && (c.over ?? opened) < opened && at - c.at_ms > LOST_MS)
        this.update({ ...c, state: "rejected", reason: NOT_ARRIVED, at_ms: at });
  }

  /** Show that the server refused it, and why. */
  refuse(grant: number, seq: number, reason: string, at: number): void {
    const known = this.rows.get(`${grant}/${seq}`), kind = known?.kind ?? "";
    if (known?.id) return; // another page's command has that number; the row tells of that one
    this.update({ id: 0, seq, grant, kind, state: "rejected", reason, at_ms: at, result: {} });
  }

  /** Whether a motion of this grant runs or waits; the kinds in `beside` run beside a motion and do not count. */
  busy(grant: number, beside: ReadonlySet<string>): boolean {
    return [...this.rows.values()].some((c) => c.grant === grant && !FINAL.has(c.state) && !beside.has(c.kind));
  }

  /** Call `then` once, when that command of this grant has ended. */
  whenEnded(grant: number, seq: number, then: (c: CommandInfo) => void): void {
    this.waiting.set(`${grant}/${seq}`, then);
  }

  /** Whether that command of this grant has ended. */
  ended(grant: number, seq: number): boolean {
    const known = this.rows.get(`${grant}/${seq}`);
    return known !== undefined && FINAL.has(known.state);
  }

  private draw(): void {
    const place = (c: CommandInfo): number => c.id || (this.sent.get(`${c.grant}/${c.seq}`) ?? 0);
    const newest = [...this.rows.values()].sort((a, b) => place(b) - place(a) || b.seq - a.seq).slice(0, 8);
    for (const [key, c] of this.rows)
      if (this.rows.size > 40 && !newest.includes(c) && this.rows.delete(key)) this.sent.delete(key);
    const keys = newest.map((c) => `${c.grant}/${c.seq}`);
    for (const key of this.items.keys()) if (!keys.includes(key)) this.items.delete(key);
    arrange(this.list, newest.map((c, i) => this.item(keys[i] ?? "", c)));
  }

  private item(key: string, c: CommandInfo): HTMLElement {
    const item = this.items.get(key) ?? row();
    this.items.set(key, item);
    draw(item, c);
    return item;
  }
}

function row(): HTMLElement {
  const item = document.createElement("li");
  const steps = document.createElement("span");
  steps.className = "steps";
  steps.setAttribute("aria-hidden", "true");
  steps.append(...GOOD.map(() => document.createElement("i")));
  const stage = document.createElement("span");
  stage.className = "chip";
  const far = document.createElement("div");
  far.className = "progress";
  far.append(document.createElement("progress"), document.createElement("span"));
  item.append(document.createElement("b"), steps, stage, document.createElement("p"), far);
  return item;
}

function draw(item: HTMLElement, c: CommandInfo): void {
  const [name, steps, stage, why, far] = item.children as unknown as HTMLElement[];
  if (!name || !steps || !stage || !why || !far) return;
  const gaveWay = GAVE_WAY.find((word) => c.reason.startsWith(word));
  item.className = `command ${FINAL.has(c.state) && c.state !== "completed" && !gaveWay ? "bad" : c.state}`;
  item.dataset["state"] = c.state;
  write(name, COMMAND_LABELS[c.kind] ?? c.kind);
  const reached = GOOD.indexOf(c.state);
  [...steps.children].forEach((dot, i) => dot.classList.toggle("on", i <= reached));
  write(stage, gaveWay ?? stageOf(c.kind, c.state));
  write(why, c.reason || c.result?.note || (c.state === "completed" && c.result?.stable === false ? `Picture: ${c.result.verdict}.` : ""));
  why.hidden = !why.textContent;
  tellProgress(far, c);
}

/** The progress of a long command while it runs; an unknown share is a bar without a value. */
function tellProgress(far: HTMLElement, c: CommandInfo): void {
  const [bar, text] = far.children as unknown as [HTMLProgressElement, HTMLElement];
  const known = c.progress?.at_ms !== undefined && !FINAL.has(c.state);
  far.hidden = !known;
  if (!known) return;
  const share = c.progress?.share;
  if (typeof share === "number") bar.value = share;
  else bar.removeAttribute("value");
  write(text, c.progress?.text ?? "");
  bar.setAttribute("aria-label", c.progress?.text || "Progress");
}

function say(c: CommandInfo): string {
  const name = COMMAND_LABELS[c.kind] ?? c.kind;
  if (c.state === "completed" && SETTING_KINDS.has(c.kind)) return `${name}: done.`;
  if (c.state === "completed") return `${name}: done, the picture is ${c.result?.verdict ?? "there"}.`;
  return c.reason.startsWith("Interrupted") ? `${name}: ${c.reason}` : `${name}: ${stageOf(c.kind, c.state)}. ${c.reason}`;
}
