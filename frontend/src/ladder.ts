/** The command ladder: each command with the stage it has reached, newest first. */
import type { CommandInfo } from "./protocol.ts";
import { FINAL, KINDS, STAGES } from "./words.ts";

const GOOD = ["accepted", "sent", "acknowledged", "completed"];

export class Ladder {
  private rows = new Map<string, CommandInfo>();
  private waiting = new Map<string, (c: CommandInfo) => void>();

  constructor(private list: HTMLElement, private live: HTMLElement) {}

  reset(commands: CommandInfo[]): void {
    for (const c of commands) this.rows.set(`${c.grant}/${c.seq}`, c);
    this.draw();
  }

  /** A stage arrived; a final one is never overwritten by an older message. */
  update(c: CommandInfo): void {
    const key = `${c.grant}/${c.seq}`;
    const known = this.rows.get(key);
    if (known && FINAL.has(known.state)) return;
    this.rows.set(key, { ...known, ...c });
    this.draw();
    if (!FINAL.has(c.state)) return;
    this.live.textContent = say({ ...known, ...c });
    this.waiting.get(key)?.(c);
    this.waiting.delete(key);
  }

  /** The server refused it: it keeps its name and says why. */
  refuse(grant: number, seq: number, reason: string, at: number): void {
    const kind = this.rows.get(`${grant}/${seq}`)?.kind ?? "";
    this.update({ id: 0, seq, grant, kind, state: "rejected", reason, at_ms: at, result: {} });
  }

  /** Tell whether a command of this grant has not ended yet. */
  busy(grant: number): boolean {
    return [...this.rows.values()].some((c) => c.grant === grant && !FINAL.has(c.state));
  }

  /** Run `then` once when that command of this grant has ended. */
  whenEnded(grant: number, seq: number, then: (c: CommandInfo) => void): void {
    this.waiting.set(`${grant}/${seq}`, then);
  }

  /** Tell whether that command of this grant has ended. */
  ended(grant: number, seq: number): boolean {
    const known = this.rows.get(`${grant}/${seq}`);
    return known !== undefined && FINAL.has(known.state);
  }

  private draw(): void {
    const newest = [...this.rows.values()].sort((a, b) => (b.id || 1e12) - (a.id || 1e12)).slice(0, 8);
    for (const key of this.rows.keys())
      if (this.rows.size > 40 && !newest.includes(this.rows.get(key)!)) this.rows.delete(key);
    this.list.replaceChildren(...newest.map((c) => row(c)));
  }
}

function row(c: CommandInfo): HTMLElement {
  const item = document.createElement("li");
  item.className = `command ${FINAL.has(c.state) && c.state !== "completed" ? "bad" : c.state}`;
  item.dataset["state"] = c.state;
  const name = document.createElement("b");
  name.textContent = KINDS[c.kind] ?? c.kind;
  const steps = document.createElement("span");
  steps.className = "steps";
  steps.setAttribute("aria-hidden", "true");
  const reached = GOOD.indexOf(c.state);
  for (let i = 0; i < GOOD.length; i++) {
    const dot = document.createElement("i");
    if (i <= reached) dot.className = "on";
    steps.append(dot);
  }
  const stage = document.createElement("span");
  stage.className = "chip";
  stage.textContent = c.reason.startsWith("Replaced") ? "Replaced" : (STAGES[c.state] ?? c.state);
  item.append(name, steps, stage);
  const note = c.reason || c.result?.note || (c.state === "completed" && c.result?.stable === false ? `Picture: ${c.result.verdict}.` : "");
  if (note) {
    const why = document.createElement("p");
    why.textContent = note;
    item.append(why);
  }
  return item;
}

function say(c: CommandInfo): string {
  const name = KINDS[c.kind] ?? c.kind;
  if (c.state === "completed") return `${name}: done, the picture is ${c.result?.verdict ?? "there"}.`;
  return `${name}: ${STAGES[c.state] ?? c.state}. ${c.reason}`;
}
