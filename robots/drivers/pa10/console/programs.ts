/** Program mode: steps as blocks and as text, tried on the ghost, run, saved, shared. */
import { byId, type PlanAnswer, request, type RobotPage, type StatePacket } from "/static/farhand/v1/console.js";
import { deg, type Judge } from "/static/farhand/v1/arm.js";
import type { Blocks } from "./blocks.ts";
import { parse, print, type Step } from "./program_text.ts";

interface Saved { id: number; name: string; text: string; shared: boolean; approved: boolean; by: string; mine: boolean }
interface Arm extends Judge { refuse(why: string): void; tool(): number[] | null; play(answer: PlanAnswer): void }

export class Programs {
  private saved: Saved[] = [];
  private current: Saved | null = null;
  private blocks: Blocks | null = null;
  private opened = false;
  private ran = false;
  private area = byId<HTMLTextAreaElement>("program-text");
  private list = byId<HTMLSelectElement>("program-list");
  private name = byId<HTMLInputElement>("program-name");
  private shared = byId<HTMLInputElement>("program-shared");
  private steps: Step[] = [];

  constructor(private page: RobotPage, private arm: Arm, private axes: string[]) {
    this.area.addEventListener("input", () => this.typed());
    this.list.addEventListener("change", () => this.load(Number(this.list.value)));
    const act: Record<string, () => void> = {
      new: () => this.clear(), here: () => this.addHere(), joints: () => this.addJoints(), save: () => void this.save(), delete: () => void this.remove(),
    };
    for (const [name, run] of Object.entries(act)) document.querySelector(`[data-program="${name}"]`)?.addEventListener("click", run);
    page.on("try", () => arm.ask());
    page.on("run", () => {
      if (page.command("program", { text: this.text() }, "run")) this.tell("The program runs; the present step is shown.", "");
    });
  }

  /** The mode was opened: fetch the list and the blocks, once. */
  async open(): Promise<void> {
    if (this.opened) return;
    this.opened = true;
    try {
      await this.refresh();
    } catch {
      this.opened = false; // the next opening tries again
      return this.tell("The list of programs did not come. Check your connection and open this mode again.", "warning");
    }
    if (!this.area.value && this.saved[0]) this.load(this.saved[0].id);
    try {
      const { Blocks } = await import("./blocks.ts");
      this.blocks = new Blocks(byId("blocks"), this.axes, (steps) => this.built(steps));
      this.blocks.show(this.steps);
    } catch (error) {
      byId("blocks").hidden = true;
      console.warn(error);
    }
  }

  text(): string {
    return this.area.value.trim();
  }

  private async refresh(): Promise<void> {
    const answer = await request(`/robots/${this.page.slug}/programs/`);
    this.saved = answer.ok ? ((await answer.json()) as { programs: Saved[] }).programs : [];
    const groups: [string, Saved[]][] = [
      ["Came with the robot", this.saved.filter((p) => !p.by)],
      ["Mine", this.saved.filter((p) => p.mine)],
      ["Gallery", this.saved.filter((p) => p.by && !p.mine)],
    ];
    const none = new Option("A new program", "0");
    this.list.replaceChildren(none, ...groups.filter(([, found]) => found.length).map(([label, found]) => {
      const group = document.createElement("optgroup");
      group.label = label;
      group.append(...found.map((p) => new Option(p.mine || !p.by ? p.name : `${p.name} (${p.by})`, String(p.id))));
      return group;
    }));
    this.list.value = String(this.current?.id ?? 0);
  }

  private load(id: number): void {
    this.current = this.saved.find((p) => p.id === id) ?? null;
    this.list.value = String(this.current?.id ?? 0);
    this.name.value = this.current?.mine ? this.current.name : "";
    this.shared.checked = this.current?.mine ? this.current.shared : false;
    this.area.value = this.current?.text ?? "";
    byId<HTMLButtonElement>("program-delete").hidden = !this.current?.mine;
    this.typed();
  }

  private clear(): void {
    this.load(0);
    this.area.focus();
  }

  private typed(): void {
    try {
      this.steps = parse(this.area.value);
      this.blocks?.show(this.steps);
      this.tell("", "");
      this.arm.ask();
    } catch (error) {
      const why = (error as Error).message;
      this.arm.refuse(why);
      this.tell(why, "bad");
    }
  }

  private built(steps: Step[]): void {
    this.steps = steps;
    this.area.value = print(steps);
    this.tell("", "");
    this.arm.ask();
  }

  private add(step: Step): void {
    this.area.value = print([...this.steps, step]);
    this.typed();
  }

  private addHere(): void {
    const here = this.arm.tool();
    if (here) this.add({ do: "pose", straight: false, values: [...here.slice(0, 3).map((v) => v * 1000), ...here.slice(3).map(deg)].map(tenth) });
  }

  private addJoints(): void {
    const { state } = this.page;
    if (state) this.add({ do: "joints", values: state.joints.slice(0, this.axes.length).map((q) => tenth(deg(q))) });
  }

  /** The server has checked the program, or refuses it. */
  checked(answer: PlanAnswer): void {
    this.tell(answer.ok ? `Checked: ${answer.seconds?.toFixed(0)} s, no forbidden box is touched.` : answer.text, answer.ok ? "good" : "bad");
    if (answer.ok) this.arm.play(answer);
  }

  /** The ghost, or the arm itself, is at this step. */
  state(packet: StatePacket): void {
    const step = /^PROG EXEC: program \d+, step (\d+)/.exec(packet.mode)?.[1];
    if (step) this.tell(`Step ${step} runs.`, "");
    else if (this.ran) this.tell("The program has ended.", "");
    this.ran = step !== undefined;
  }

  private tell(words: string, kind: string): void {
    const box = byId("program-said");
    if (box.textContent === words) return;
    box.textContent = words;
    box.className = `program-said ${kind}`;
  }

  private async save(): Promise<void> {
    const id = this.current?.mine ? this.current.id : undefined;
    const said = await this.ask("POST", { id, name: this.name.value, text: this.text(), shared: this.shared.checked });
    if (!said) return;
    this.current = said as Saved;
    this.tell(this.current.shared && !this.current.approved ? "Saved. It appears in the gallery after staff have approved it." : "Saved.", "good");
    await this.refresh();
    byId<HTMLButtonElement>("program-delete").hidden = false;
  }

  private async remove(): Promise<void> {
    if (!this.current?.mine || !(await this.ask("DELETE", { id: this.current.id }))) return;
    this.current = null;
    await this.refresh();
    this.clear();
    this.tell("Deleted.", "");
  }

  private async ask(method: string, what: object): Promise<object | null> {
    const token = document.querySelector<HTMLInputElement>("#program-form [name=csrfmiddlewaretoken]")?.value ?? "";
    try {
      const answer = await request(`/robots/${this.page.slug}/programs/`, {
        method, body: JSON.stringify(what), headers: { "Content-Type": "application/json", "X-CSRFToken": token },
      });
      const said = (await answer.json()) as { error?: string };
      if (answer.ok) return said;
      this.tell(said.error ?? "The program was not saved.", "bad");
    } catch {
      this.tell("The server does not answer; your program is still here. Try again in a moment.", "bad");
    }
    return null;
  }
}

function tenth(value: number): number {
  return Math.round(value * 10) / 10;
}
