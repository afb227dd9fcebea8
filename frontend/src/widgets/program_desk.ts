/** Programs of a robot's own language: as text and as blocks, saved, shared, fetched from the gallery. */
import { byId, make } from "../kit/dom.ts";
import { allow } from "../kit/refusal.ts";
import { request } from "../kit/request.ts";
import { storage } from "../kit/storage.ts";
import { gettext, translate } from "../kit/text.ts";
import { saidOf } from "../page/command_list.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { CommandInfo, Judgement } from "../socket/messages.ts";
import { FINAL } from "../socket/stages.ts";

/** A robot's language: `parse` throws a sentence that names the line. */
export interface Language<Step> {
  parse(text: string): Step[];
  print(steps: readonly Step[]): string;
}
export interface StepBlocks<Step> {
  show(steps: readonly Step[]): void;
}
/** What a console does with programs. */
export interface ProgramUse<Step> {
  /** Load the blocks, once, and show them in `box`; `changed` gets the steps after each change by a person. */
  blocks(box: HTMLElement, changed: (steps: Step[]) => void): Promise<StepBlocks<Step>>;
  /** The steps have changed, and may be tried. */
  changed(steps: readonly Step[]): void;
  /** The text is no program; `why` says where. */
  refused(why: string): void;
}
interface Saved {
  id: number;
  name: string;
  text: string;
  shared: boolean;
  approved: boolean;
  by: string;
  mine: boolean;
}

const TOO_LARGE = gettext("Over this slow line the blocks are not loaded by themselves: they would hold up everything else.");
const DRAFT_MS = 400; // after the last key, until the draft is stored on this device

export class ProgramDesk<Step> {
  steps: Step[] = [];
  private saved: Saved[] = [];
  private current: Saved | null = null;
  private blocks: StepBlocks<Step> | null = null;
  private opened = false;
  private loading = false;
  private asking = false;
  private readonly page: RobotPage;
  private readonly language: Language<Step>;
  private readonly noun: string;
  private readonly use: ProgramUse<Step>;
  private readonly kind: string;
  private keeping = 0;
  private area: HTMLTextAreaElement;
  private list: HTMLSelectElement;
  private name: HTMLInputElement;
  private shared: HTMLInputElement;
  /** What is said of saved ones: a line of its own, so that the answer to a check does not take its place. */
  private saving: HTMLElement;
  private runs = ""; // which one is under way, so that how it ends is told; empty: none
  private told = ""; // what was last told of it

  /**
   * `noun`: what a program of this robot is called. Of a robot with several languages, `kind` is the command of this one,
   * and the elements of its desk have ids and data attributes that begin with it in place of `program`.
   */
  constructor(page: RobotPage, language: Language<Step>, noun: string, use: ProgramUse<Step>, kind = "") {
    [this.page, this.language, this.noun, this.use, this.kind] = [page, language, noun, use, kind];
    this.area = byId<HTMLTextAreaElement>(this.id("text"));
    this.list = byId<HTMLSelectElement>(this.id("list"));
    this.name = byId<HTMLInputElement>(this.id("name"));
    this.shared = byId<HTMLInputElement>(this.id("shared"));
    this.saving = make("p", { id: this.id("saved"), class: "program-said", role: "status" });
    (this.button("save")?.closest("p") ?? byId(this.id("said"))).after(this.saving);
    this.area.addEventListener("input", () => this.typed());
    this.list.addEventListener("change", () => this.load(Number(this.list.value)));
    const act: Record<string, () => void> = { new: () => this.clear(), save: () => void this.save(), delete: () => void this.remove() };
    for (const [name, run] of Object.entries(act)) this.button(name)?.addEventListener("click", run);
  }

  /** Load the list and the blocks, once; called whenever the mode is opened. */
  async open(): Promise<void> {
    void this.openBlocks();
    if (this.opened) return;
    this.opened = true;
    this.restore();
    try {
      await this.refresh();
    } catch {
      this.opened = false; // the next opening tries again
      this.tellSaved(gettext("The list of saved ones did not come. What you write here works all the same."), "warning");
      return;
    }
    if (!this.area.value && this.saved[0]) this.load(this.saved[0].id);
  }

  /** Show the draft that is stored on this device, unless something is written already. */
  private restore(): void {
    const draft = this.area.value ? "" : storage.get(this.place);
    if (!draft) return;
    this.area.value = draft;
    this.typed();
  }

  /** `asked`: somebody has pressed the button for it, over whatever line. */
  private async openBlocks(asked = false): Promise<void> {
    if (this.blocks || this.loading) return;
    const box = byId(this.kind ? this.id("blocks") : "blocks");
    if (this.page.thin && !asked) {
      this.offerBlocks(box, TOO_LARGE, gettext("Load the blocks"), () => void this.openBlocks(true));
      return;
    }
    this.loading = true;
    box.replaceChildren();
    try {
      this.blocks = await this.use.blocks(box, (steps) => this.built(steps));
      this.blocks.show(this.steps);
    } catch (error) {
      // a browser does not load a module again that failed once
      this.offerBlocks(
        box,
        gettext("The blocks did not come. Reload the page when the connection is back."),
        gettext("Reload the page"),
        () => {
          this.store();
          location.reload();
        },
      );
      console.warn(error);
    }
    this.loading = false;
  }

  /** Say in the place of the blocks why they are not there, with a button to load them. */
  private offerBlocks(box: HTMLElement, why: string, label: string, act: () => void): void {
    const load = make("button", { type: "button", class: "button" }, label);
    load.addEventListener("click", act);
    box.replaceChildren(make("p", { role: "status" }, `${why} ${gettext("Lines of text work without them.")}`), load);
  }

  /** Return the id of an element of this desk. */
  private id(name: string): string {
    return `${this.kind || "program"}-${name}`;
  }

  private button(name: string): HTMLElement | null {
    return document.querySelector<HTMLElement>(`[data-${this.kind || "program"}="${name}"]`);
  }

  text(): string {
    return this.area.value.trim();
  }

  /** Whether the text is that of the saved program. */
  private get unchanged(): boolean {
    return this.current?.text.trim() === this.text();
  }

  /** Begin a new program where one is shown as it was saved; what somebody has written stays. */
  fresh(): void {
    this.restore();
    if (this.current && this.unchanged) this.load(0);
  }

  /** Append steps. */
  add(...steps: Step[]): void {
    this.area.value = [this.area.value.trimEnd(), this.language.print(steps)].filter(Boolean).join("\n");
    this.typed();
  }

  /** Take away the last lines, if they are these steps. */
  takeBack(...steps: Step[]): void {
    const lines = `\n${this.language.print(steps)}`,
      written = `\n${this.area.value.trimEnd()}`;
    if (!written.endsWith(lines)) return;
    this.area.value = written.slice(1, -lines.length);
    this.typed();
  }

  /** Show a text under the program; `kind`: good, bad, warning, or empty. That all is well with it gives way to what runs. */
  tell(words: string, kind: string): void {
    if (kind !== "good" || !this.runs) write(byId(this.id("said")), words, kind);
  }

  private tellSaved(words: string, kind: string): void {
    write(this.saving, words, kind);
  }

  /** Tell what becomes of the newest command of that kind, by its row in the list of commands; called again and again. */
  follow(c: CommandInfo | undefined): void {
    const which = c ? `${c.grant}/${c.seq}` : "",
      ended = c === undefined || FINAL.has(c.state);
    if (ended && this.runs !== which) return; // it had ended before the page knew of it
    this.runs = ended ? "" : which;
    if (!c) return;
    const [words, kind] = becameOf(c);
    if (words === this.told && byId(this.id("said")).textContent) return;
    this.told = words;
    write(byId(this.id("said")), words, kind);
  }

  /** Show the judgements of its steps in the element `program-judged`, if the page has one. */
  judge(said: readonly Judgement[]): void {
    const items = said.map(({ text, at_s, refuses }) =>
      make("li", { class: refuses ? "bad" : "warning" }, judgement(refuses, minutes(at_s), translate(text))),
    );
    document.getElementById(this.id("judged"))?.replaceChildren(...items);
  }

  private async refresh(): Promise<void> {
    const answer = await request(`/robots/${this.page.slug}/programs/?kind=${this.kind}`);
    this.saved = answer.ok ? ((await answer.json()) as { programs: Saved[] }).programs : [];
    const group = (label: string, belongs: (p: Saved) => boolean): HTMLElement[] => {
      const options = this.saved.filter(belongs).map((p) => new Option(nameOf(p), String(p.id)));
      return options.length ? [make("optgroup", { label }, ...options)] : [];
    };
    this.list.replaceChildren(
      new Option(gettext("A new {noun}", { noun: this.noun }), "0"),
      ...group(gettext("Came with the robot"), (p) => !p.by),
      ...group(gettext("Mine"), (p) => p.mine),
      ...group(gettext("Gallery"), (p) => p.by !== "" && !p.mine),
    );
    this.list.value = String(this.current?.id ?? 0);
  }

  private load(id: number): void {
    this.current = this.saved.find((p) => p.id === id) ?? null;
    this.list.value = String(this.current?.id ?? 0);
    this.name.value = this.current?.mine ? this.current.name : "";
    this.shared.checked = this.current?.mine ? this.current.shared : false;
    this.area.value = this.current?.text ?? "";
    byId<HTMLButtonElement>(this.id("delete")).hidden = !this.current?.mine;
    this.typed();
  }

  private clear(): void {
    this.load(0);
    this.area.focus();
  }

  private typed(): void {
    if (this.read()) this.blocks?.show(this.steps);
  }

  private built(steps: Step[]): void {
    this.area.value = this.language.print(steps);
    this.read();
  }

  /** Read the text, also one that the blocks wrote, because the text is what is sent. Returns whether it is a program. */
  private read(): boolean {
    this.keep();
    try {
      this.steps = this.language.parse(this.area.value);
    } catch (error) {
      const why = translate((error as Error).message);
      this.tell(why, "bad");
      this.judge([]);
      this.use.refused(why);
      return false;
    }
    this.tell("", "");
    if (!this.asking) this.tellSaved("", "");
    this.judge([]);
    this.use.changed(this.steps);
    return true;
  }

  /** Store the draft on this device, so that a reload or a lost connection loses nothing. */
  private store(): void {
    clearTimeout(this.keeping);
    storage.set(this.place, this.unchanged ? "" : this.area.value);
  }

  /** Store it soon. */
  private keep(): void {
    clearTimeout(this.keeping);
    this.keeping = window.setTimeout(() => this.store(), DRAFT_MS);
  }

  private get place(): string {
    return `${this.kind || "program"}-${this.page.slug}`;
  }

  /** Enable the buttons that need the server, or disable them with a reason. */
  enable(why: string): void {
    for (const name of ["save", "delete"]) allow(this.button(name)!, why);
  }

  private async save(): Promise<void> {
    const id = this.current?.mine ? this.current.id : undefined;
    const said = await this.ask("POST", { id, name: this.name.value, text: this.text(), shared: this.shared.checked, kind: this.kind });
    if (!said) return;
    this.current = said as Saved;
    this.keep();
    const awaited = this.current.shared && !this.current.approved;
    this.tellSaved(awaited ? gettext("Saved. It appears in the gallery after staff have approved it.") : gettext("Saved."), "good");
    await this.refresh();
    byId<HTMLButtonElement>(this.id("delete")).hidden = false;
  }

  private async remove(): Promise<void> {
    if (!this.current?.mine || !(await this.ask("DELETE", { id: this.current.id }))) return;
    this.current = null;
    await this.refresh();
    this.clear();
    this.tellSaved(gettext("Deleted."), "");
  }

  /** Send a request. Resolves to the answer; null if it failed, which is shown, or while another request runs. */
  private async ask(method: string, what: object): Promise<object | null> {
    if (this.asking) return null;
    this.asking = true;
    this.tellSaved(method === "DELETE" ? gettext("Deleting…") : gettext("Saving…"), "");
    const token = document.querySelector<HTMLInputElement>(`#${this.id("form")} [name=csrfmiddlewaretoken]`)?.value ?? "";
    try {
      const answer = await request(`/robots/${this.page.slug}/programs/`, {
        method,
        body: JSON.stringify(what),
        headers: { "Content-Type": "application/json", "X-CSRFToken": token },
      });
      const said = (await answer.json()) as { error?: string };
      if (answer.ok) return said;
      this.tellSaved(said.error ? translate(said.error) : gettext("The {noun} was not saved.", { noun: this.noun }), "bad");
    } catch {
      this.tellSaved(gettext("The server does not answer; your {noun} is still here. Try again in a moment.", { noun: this.noun }), "bad");
    } finally {
      this.asking = false;
    }
    return null;
  }
}

/** Return a program's name as the list shows it: one that came with the robot in the reader's language. */
function nameOf({ name, by, mine }: Saved): string {
  if (!by) return translate(name);
  return mine ? name : `${name} (${by})`;
}

/** Show a text in one of a desk's lines. */
function write(line: HTMLElement, words: string, kind: string): void {
  if (line.textContent === words) return;
  line.textContent = words;
  line.className = `program-said ${kind}`;
}

/** Return what becomes of a command that was sent, and the style of that. */
function becameOf(c: CommandInfo): [words: string, kind: string] {
  if (FINAL.has(c.state)) {
    const { mark, chip, why } = saidOf(c);
    return [`${chip}. ${why}`.trim(), mark === "completed" ? "good" : mark];
  }
  const step = translate(c.progress?.text ?? "");
  if (step) return [gettext("It runs: {step}.", { step }), ""];
  return [c.state === "acknowledged" ? gettext("It runs.") : gettext("It is sent and has not begun yet."), ""];
}

function judgement(refuses: boolean, time: string, text: string): string {
  return refuses ? gettext("Will not run, after {time}: {text}", { time, text }) : gettext("Note, after {time}: {text}", { time, text });
}

/** Return seconds as minutes and seconds. */
export function minutes(seconds: number): string {
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")} min`;
}
