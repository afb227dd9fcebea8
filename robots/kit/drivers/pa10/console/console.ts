/** The museum arm's console: cameras, a view in three dimensions; joint, position, task, program and terminal modes. */
import { type ArmDescription, deg, Joints, type Judge, Position, type Target } from "/static/farhand/v1/arm.js";
import type { ArmView, ForbiddenBox } from "/static/farhand/v1/arm_view.js";
import {
  allow,
  blocked,
  byId,
  type CameraView,
  type CommandInfo,
  type Console,
  facts,
  type Facts,
  fill,
  FINAL,
  type PicturePacket,
  type PlanAnswer,
  request,
  RobotPage,
  say,
  type StatePacket,
  type Still,
  Tabs,
} from "/static/farhand/v1/console.js";
import "./terminal.css";
import { Cameras } from "./cameras.ts";
import { Programs } from "./programs.ts";
import { Tasks } from "./tasks.ts";
import { Terminal } from "./terminal.ts";

interface Plan {
  key: string;
  ok: boolean;
  text: string;
}

const description = facts as typeof facts & ArmDescription & { set: { boxes?: ForbiddenBox[] }; objects: { name: string }[] };
const NAMES = description.joints.map((j) => j.name);
const page = new RobotPage();
const POSTURES = ["ready", "home"]; // of robot.toml
const FINGERS = ["left_finger", "right_finger"]; // the joints of the model for the one width in the state
const PLAN_MS = 120;
const MODEL_MS = 120_000; // the file may come over a slow line
const THERE = 0.002; // rad: a target this near needs no ghost
/** The command of each mode; the terminal checks its lines itself. */
const ASKED_FOR: Record<string, string> = { joint: "go", position: "go", task: "run-task", program: "run" };
/** The kind of command of each button, as `whyNot` judges it. */
const BUTTONS = {
  open: "gripper",
  close: "gripper",
  ready: "ready",
  "go-joints": "go",
  "go-pose": "go",
  "run-task": "run-task",
  run: "run",
};
const NO_STEP: Record<string, string> = { run: "The program has no step.", "run-task": "The task has no step." };
const WRITTEN = new Set(["task", "program"]); // modes whose target is asked about again only after a refusal: that was from another place
/** The kinds of motion that a newer target may replace. */
const replaceable = new Set(facts.commands.filter((c) => c.replaceable).map((c) => c.kind));

class ArmConsole implements Console, Judge {
  readonly video = true;
  private cameras = new Cameras(page);
  private view: ArmView | null = null;
  private plan: Plan | null = null;
  private planned = 0;
  private planTimer = 0;
  private known = false; // whether a state has come
  private tabs = new Tabs(byId("modes"), (name) => this.changed(name));
  private joints: Joints;
  private position: Position;
  private tasks: Tasks;
  private programs: Programs;

  constructor() {
    const speed = byId<HTMLInputElement>("speed");
    speed.addEventListener("input", () => {
      say(byId("speed-said"), `${speed.value} %`);
      this.ask();
    });
    const share = (): number => Number(speed.value) / 100;
    this.joints = new Joints(page, this, description.joints, share, "jog_joints");
    this.position = new Position(page, this, share, () => this.tool(), "jog_tool");
    const objects = description.objects.map(({ name }) => name);
    this.tasks = new Tasks(page, this, objects, POSTURES);
    this.programs = new Programs(page, this, NAMES);
    new Terminal(page, this, NAMES);
    page.on("open", () => page.command("gripper", { closed: 0 }));
    page.on("close", () => page.command("gripper", { closed: 1 }));
    page.on("ready", () => page.command("ready"));
    page.on("go-joints", () => this.go(this.joints.target()));
    page.on("go-pose", () => this.go(this.position.target()));
    page.onPlan = (answer) => this.gotPlan(answer);
    void this.openView();
  }

  private async openView(): Promise<void> {
    try {
      const [{ ArmView }, answer] = await Promise.all([import("/static/farhand/v1/arm_view.js"), request(description.model, {}, MODEL_MS)]);
      if (!answer.ok) throw new Error(`the model answered ${answer.status}`);
      const names = [...NAMES.map((name) => [name]), FINGERS];
      const boxes = [...description.boxes, ...(description.set.boxes ?? [])];
      this.view = new ArmView(byId("model"), await answer.text(), names, description.tip, boxes, (x, y) => {
        if (byId("modes").hidden) return;
        this.tabs.choose("position");
        this.position.place(x, y);
      });
      for (const button of byId("model").querySelectorAll<HTMLElement>("[data-zoom]"))
        button.addEventListener("click", () => this.view?.zoom(Number(button.dataset["zoom"])));
      if (page.state) this.view.joints(page.state.joints);
      this.position.follow();
      this.ask();
    } catch (error) {
      byId("model").dataset["broken"] = "yes";
      say(byId("model-said"), "The 3D view does not work in this browser; cameras and controls do.");
      console.warn(error);
    }
  }

  watch(): void {
    this.cameras.watch();
  }

  picture(packet: PicturePacket): void {
    this.cameras.picture(packet);
  }

  still(still: Still): void {
    this.cameras.still(still);
  }

  shown(camera: number): CameraView | undefined {
    return this.cameras.shown(camera);
  }

  pictureAt(): number {
    return this.cameras.atMs;
  }

  state(packet: StatePacket): void {
    this.view?.joints(packet.joints);
    this.joints.show(packet);
    this.programs.state(packet);
    say(byId("mode"), packet.mode);
    showReadings(packet);
    if (!this.known || this.tabs.open === "position") this.position.follow();
    if (!this.known) this.ask();
    this.known = true;
  }

  turn(): void {
    this.plan = null;
    this.joints.take(page.state?.joints ?? []);
    this.position.take();
  }

  command(c: CommandInfo): void {
    if (!FINAL.has(c.state)) return;
    if (c.state === "completed" && c.kind !== "gripper") {
      this.joints.arrived(c.seq);
      this.position.arrived(c.seq);
    }
    if (!WRITTEN.has(this.tabs.open) || this.plan?.ok === false) this.ask();
  }

  /** Return the target of the open mode; null if it has none. */
  private target(): Target | null {
    if (this.tabs.open === "joint") return this.joints.target();
    const written = this.written();
    if (written) return written.text() ? { kind: this.tabs.open, args: { text: written.text() } } : null;
    return this.tabs.open === "position" ? this.position.target() : null;
  }

  /** Return what the open mode lets people write, if it does: tasks or programs. */
  private written(): Tasks | Programs | null {
    return this.tabs.open === "task" ? this.tasks : this.tabs.open === "program" ? this.programs : null;
  }

  private changed(name: string): void {
    for (const part of document.querySelectorAll<HTMLElement>(".arm-console")) part.dataset["mode"] = name;
    this.plan = null;
    this.noGhost();
    this.position.follow();
    page.settle();
    void this.written()?.open();
    this.ask();
  }

  /** Ask the server where the target would lead, a moment after the last change. */
  ask(): void {
    clearTimeout(this.planTimer);
    this.planned += 1; // an answer that is still on its way belongs to an earlier target
    this.planTimer = window.setTimeout(() => {
      const target = byId("modes").hidden ? null : this.target();
      const outside = this.tabs.open === "position" ? this.position.outside() : "";
      if (!target || !page.state) this.noGhost();
      else if (outside) this.refuse(outside);
      else {
        this.plan = { key: JSON.stringify(target), ok: false, text: "" };
        page.live.send({ t: "plan", n: this.planned, ...target, from: page.state.joints });
      }
    }, PLAN_MS);
  }

  private noGhost(): void {
    this.view?.target(null);
    if (!byId("model").dataset["broken"]) say(byId("model-said"), "");
  }

  /** Refuse the target without asking the server, and drop earlier questions. */
  refuse(why: string): void {
    clearTimeout(this.planTimer);
    this.planned += 1;
    this.plan = { key: JSON.stringify(this.target()), ok: false, text: why };
    this.noGhost();
    page.draw();
  }

  tool(): number[] | null {
    return page.state && this.view ? this.view.tool() : null;
  }

  /** Move the ghost through a program, and show its step. */
  play(answer: PlanAnswer): void {
    this.view?.refused(false);
    this.view?.play(answer.path ?? [], answer.tool ?? [], (i) => {
      const step = answer.steps?.[i] ?? 0;
      say(byId("model-said"), step ? `The ghost is at step ${step}` : "");
    });
  }

  private gotPlan(answer: PlanAnswer): void {
    if (answer.n !== this.planned || !this.plan) return;
    this.plan = { ...this.plan, ok: answer.ok, text: answer.text };
    const written = this.written();
    if (written) {
      written.checked(answer);
      return page.draw();
    }
    this.view?.refused(!answer.ok);
    const there = answer.joints?.every((q, i) => Math.abs(q - (page.state?.joints[i] ?? Infinity)) < THERE) ?? false;
    if (answer.joints && !there) this.view?.target(answer.joints, answer.tool ?? []);
    else this.view?.target(null);
    const way = there ? "The arm is there" : `${answer.seconds?.toFixed(1)} s on the way`;
    say(byId("model-said"), answer.ok ? way : answer.text);
    page.draw();
  }

  private go(target: Target | null): void {
    if (target) page.command(target.kind, target.args, "go");
    else page.refuse(() => this.whyNot("go", page.facts()));
  }

  whyNot(kind: string, f: Facts): string {
    const general = blocked(f);
    if (general) return general;
    const running = page.snapshot?.commands.find((c) => !FINAL.has(c.state));
    if (f.busy && running && (kind !== "go" || !replaceable.has(running.kind))) return "One command at a time: the arm is still busy.";
    if (kind !== "go" && kind !== "run" && kind !== "run-task") return "";
    const target = this.target();
    if (!target) return NO_STEP[kind] ?? "Fill in every value with a number first.";
    if (this.plan?.key === JSON.stringify(target) && this.plan.text && !this.plan.ok) return this.plan.text;
    return "";
  }

  advice(f: Facts): string {
    return f.busy ? "The arm is busy." : this.whyNot(ASKED_FOR[this.tabs.open] ?? "jog", f);
  }

  draw(f: Facts): void {
    byId("modes").hidden = !page.operating && !page.snapshot?.me.cleared;
    for (const [name, kind] of Object.entries(BUTTONS)) {
      const button = document.querySelector<HTMLElement>(`[data-command="${name}"]`);
      if (button) allow(button, this.whyNot(kind, f));
    }
    const why = this.whyNot("jog", f);
    this.joints.enable(why);
    this.position.enable(why);
  }
}

/** Show the newest state in the table of readings. */
function showReadings({ joints, velocities, torques }: StatePacket): void {
  const rows = NAMES.map((name, i) => {
    const v = velocities[i],
      t = torques[i];
    const angle = `${deg(joints[i] ?? 0).toFixed(1)}°`;
    return [name, angle, v === undefined ? "" : `${deg(v).toFixed(1)} °/s`, t === undefined ? "" : `${t.toFixed(1)} N m`];
  });
  const width = `${(1000 * (joints[NAMES.length] ?? 0)).toFixed(0)} mm`;
  fill(byId("readings").querySelector("tbody")!, [...rows, ["Gripper", width, "", ""]]);
}

page.begin(new ArmConsole());
