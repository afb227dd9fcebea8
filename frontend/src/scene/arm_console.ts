/** The console of an arm: cameras, the view in three dimensions, scene, joint and position mode; a robot adds its own modes. */
import { byId, say } from "../kit/dom.ts";
import { allow } from "../kit/refusal.ts";
import { request } from "../kit/request.ts";
import { Tabs } from "../kit/tabs.ts";
import { decimals, gettext, translate } from "../kit/text.ts";
import type { CameraView } from "../media/camera_view.ts";
import type { ArmFacts } from "../motion/facts.ts";
import type { Console } from "../page/console.ts";
import { blocked, type Facts } from "../page/controls.ts";
import { configKinds, facts } from "../page/facts.ts";
import { sayWord } from "../page/plain_words.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { Judgement } from "./judge.ts";
import { loadJudge } from "./load_judge.ts";
import { SceneObjects } from "./objects.ts";
import { Scene, type SceneFacts } from "./scene.ts";
import type { CommandInfo, PlanAnswer, Still } from "../socket/messages.ts";
import type { PathPacket, PicturePacket, StatePacket, StreamPacket } from "../socket/packets.ts";
import { FINAL } from "../socket/stages.ts";
import { BUTTONS, PICKING } from "../arm/buttons.ts";
import { Cameras } from "../arm/cameras.ts";
import { Joints } from "../arm/joints.ts";
import { Position } from "../arm/position.ts";
import { GoBack } from "../widgets/go_back.ts";
import { Prediction } from "../arm/prediction.ts";
import { Tasks } from "../arm/tasks.ts";
import { Pick, type PickFacts } from "./pick.ts";
import { showReadings } from "../arm/readings.ts";
import { type ArmDescription, type ArmMode, type ArmParts, type Judge, type Plan, type Target } from "../arm/types.ts";
import type { ArmView, ForbiddenBox } from "../arm/view.ts";
import { WatchedGoal } from "./watched_goal.ts";

const description = facts as typeof facts & ArmDescription & ArmFacts & SceneFacts & PickFacts & { set: { boxes?: ForbiddenBox[] } };
const boxes = description.set.boxes ?? []; // of staff
const PLAN_MS = 120;
const MODEL_MS = 120_000; // the file may come over a slow line
const MOVES = ["joints", "pose", "line", "ready"]; // to a position
const THERE = 0.002; // rad: a target this near needs no ghost
/** The kinds of motion that a newer target may replace. */
const replaceable = new Set(facts.commands.filter((c) => c.replaceable).map((c) => c.kind));

export class ArmConsole implements Console, Judge {
  readonly video = true;
  /** The names of the arm's joints. */
  readonly axes = description.joints.map((j) => j.name);
  private cameras: Cameras;
  private view: ArmView | null = null;
  private prediction = new Prediction(
    () => this.page.live.now(),
    (q) => this.view?.toolAt(q) ?? null,
  );
  private goal = new WatchedGoal(() => this.page);
  private plan: Plan | null = null;
  private planned = 0;
  private planTimer = 0;
  private sentTo: { seq: number; target: string } | null = null; // the newest target that was sent
  private known = false; // whether a state has come
  private completed: CommandInfo | null = null; // the newest motion of which no state tells where the arm is since
  private tabs = new Tabs(byId("modes"), (name) => this.changed(name));
  private joints: Joints;
  private position: Position;
  private scene: Scene | null = null; // null where the template has no tab for it
  private task: Tasks | null = null; // likewise
  private pick: Pick | null; // null for a robot that does not declare it
  private modes: Record<string, ArmMode>;
  private back: GoBack;

  /** `modes` makes the robot's own modes, by the names of their tabs. */
  constructor(
    private page: RobotPage,
    private parts: ArmParts,
    modes: (console: ArmConsole) => Record<string, ArmMode> = () => ({}),
  ) {
    this.cameras = new Cameras(page);
    const speed = byId<HTMLInputElement>("speed");
    speed.addEventListener("input", () => {
      say(byId("speed-said"), `${speed.value} %`);
      this.ask();
    });
    const share = (): number => Number(speed.value) / 100;
    this.joints = new Joints(page, this, description.joints, share, "jog_joints");
    this.position = new Position(page, this, share, () => this.tool(), "jog_tool");
    const { objects, objects_box, release_m = 0 } = description,
      around = objects && objects_box ? new SceneObjects(objects, objects_box, release_m, description) : null;
    this.pick = Pick.of(page, description, {
      cameras: this.cameras,
      objects: around,
      changed: () => {
        page.draw();
        this.ask();
      },
      start: (target) => this.start(target, "go-pick"),
    });
    if (document.getElementById("panel-task")) this.task = new Tasks(page, this, description);
    if (document.getElementById("panel-scene"))
      this.scene = new Scene(page, {
        share,
        axes: this.axes.length,
        tell: (text) => this.tell(text),
        start: (target) => this.start(target),
        sent: (seq, judged) => this.sent(seq, judged),
        cameras: description.view ?? [],
        pictures: this.cameras,
        objects: around,
        task: this.task,
        showTask: () => this.tabs.choose("task"),
      });
    this.modes = {
      ...(this.scene ? { scene: this.scene } : {}),
      joint: { asked: "go", target: () => this.joints.target() },
      position: { asked: "go", target: () => this.position.target(), outside: () => this.position.outside() },
      ...(this.task ? { task: this.task } : {}),
      ...modes(this),
    };
    this.back = new GoBack(page, {
      kinds: MOVES,
      joints: this.axes.length,
      whyNot: () => this.whyNot("back", page.facts()),
      choose: (joints) => this.goBack(joints),
    });
    page.on("open", () => this.grip(0));
    page.on("close", () => this.grip(1));
    page.on("ready", () => page.command("ready"));
    page.on("go-joints", () => this.go(this.joints.target()));
    page.on("go-pose", () => this.go(this.position.target()));
    page.onPlan = (answer) => this.gotPlan(answer);
    this.mark(this.tabs.open);
    if (this.scene) void loadJudge(description, boxes).then((judge) => this.scene?.plan(judge));
    void this.openView();
  }

  private async openView(): Promise<void> {
    try {
      const [{ SceneView }, answer] = await Promise.all([import("./view.ts"), request(description.model, {}, MODEL_MS)]);
      if (!answer.ok) throw new Error(`the model answered ${answer.status}`);
      const names = [...this.axes.map((name) => [name]), ...this.parts.moved];
      const view = new SceneView(byId("model"), await answer.text(), names, description.tip, [...description.boxes, ...boxes], (x, y) => {
        if (byId("modes").hidden || this.tabs.open === "scene") return;
        this.tabs.choose("position");
        this.position.place(x, y);
      });
      this.view = view;
      for (const button of byId("model").querySelectorAll<HTMLElement>("[data-zoom]"))
        button.addEventListener("click", () => view.zoom(Number(button.dataset["zoom"])));
      view.expect(this.prediction);
      if (this.page.state) view.joints(this.parts.posture(this.page.state));
      this.scene?.attach(view);
      if (this.pick) this.pick.view = view;
      this.position.follow();
      this.ask();
    } catch (error) {
      byId("model").dataset["broken"] = "yes";
      say(
        byId("model-said"),
        gettext("The 3D view did not come, or does not work in this browser. Reload the page to try again; cameras and controls work."),
      );
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

  path(packet: PathPacket): void {
    this.prediction.begin(packet);
    this.view?.expect(this.prediction);
    this.goal.begin(packet);
  }

  /** Expect a motion from rest that was just sent: it begins once the command has arrived. */
  private sent(seq: number, judged: (from: readonly number[]) => Judgement): void {
    const { live, state } = this.page;
    if (state) this.prediction.ask(seq, state.joints.slice(0, this.axes.length), (live.latency ?? 0) / 2, judged);
    this.view?.expect(this.prediction);
  }

  state(packet: StatePacket): void {
    const expected = this.prediction.runs;
    this.prediction.state(packet);
    if (expected) this.view?.expect(this.prediction);
    this.view?.joints(this.parts.posture(packet));
    this.arrive();
    this.joints.show(packet);
    for (const mode of Object.values(this.modes)) mode.state?.(packet);
    this.pick?.state(packet);
    sayWord(byId("mode"), packet.mode);
    showReadings(this.axes, packet, this.parts.gripper(packet));
    if (!this.known || this.tabs.open === "position") this.position.follow();
    if (!this.known) this.ask();
    this.known = true;
  }

  stream(name: string, packet: StreamPacket): void {
    this.scene?.stream(name, packet);
  }

  turn(): void {
    this.plan = this.sentTo = null;
    this.pick?.clear();
    this.joints.take(this.page.state?.joints ?? []);
    this.position.take();
    this.scene?.turn();
  }

  command(c: CommandInfo): void {
    this.prediction.command(c);
    this.pick?.command(c);
    if (!FINAL.has(c.state)) return;
    if (c.state === "completed" && c.kind !== "gripper") this.completed = c;
    this.arrive();
    if (!this.mode?.checked || this.plan?.ok === false) this.ask(); // the refusal was for a path from another place
  }

  /** Let everything follow the arm again after a motion, once a state tells where it is then: over a thin line that is later. */
  private arrive(): void {
    const { completed, page } = this;
    if (!completed || !page.state || page.state.atMs < completed.at_ms) return;
    this.completed = null;
    for (const one of [this.joints, this.position, this.scene]) one?.arrived(completed.seq);
  }

  private get mode(): ArmMode | undefined {
    return this.pick?.active ? this.pick : this.modes[this.tabs.open];
  }

  /** Return the target of the open mode; null if it has none. */
  private target(): Target | null {
    return this.mode?.target() ?? null;
  }

  private mark(name: string): void {
    for (const part of document.querySelectorAll<HTMLElement>(".arm-console")) part.dataset["mode"] = name;
  }

  private changed(name: string): void {
    this.mark(name);
    this.plan = null;
    this.pick?.clear();
    this.noGhost();
    this.position.follow();
    this.page.settle();
    this.showScene();
    this.mode?.open?.();
    this.ask();
  }

  private showScene(): void {
    this.scene?.show(this.tabs.open === "scene" && !byId("modes").hidden && !this.pick?.active);
  }

  /** Ask the server where the target would lead, a moment after the last change. */
  ask(): void {
    clearTimeout(this.planTimer);
    this.planned += 1; // an answer that is still on its way belongs to an earlier target
    if (this.mode?.local) return this.mode.again?.();
    this.planTimer = window.setTimeout(() => {
      const target = byId("modes").hidden ? null : this.target();
      const outside = this.mode?.outside?.() ?? "";
      if (!target || !this.page.state) this.noGhost();
      else if (outside) this.refuse(outside);
      else {
        this.plan = { key: JSON.stringify(target), ok: false, text: "" };
        this.page.live.send({ t: "plan", n: this.planned, ...target, from: this.page.state.joints });
      }
    }, PLAN_MS);
  }

  private noGhost(): void {
    this.view?.target(null);
    this.tell("");
  }

  /** Show a sentence over the view, unless that has to say that it does not work. */
  private tell(text: string): void {
    if (!byId("model").dataset["broken"]) say(byId("model-said"), text);
  }

  /** Refuse the target without asking the server, and drop earlier questions. */
  refuse(why: string): void {
    clearTimeout(this.planTimer);
    this.planned += 1;
    this.plan = { key: JSON.stringify(this.target()), ok: false, text: translate(why) };
    this.noGhost();
    this.page.draw();
  }

  /** Return the tool's position (m) and rotation (rad); null if they are not known. */
  tool(): number[] | null {
    return this.page.state && this.view ? this.view.tool() : null;
  }

  /** Move the ghost through a program, and show its step. */
  play(answer: PlanAnswer): void {
    this.view?.refused(false);
    this.view?.play(answer.path ?? [], answer.tool ?? [], (i) => {
      const step = answer.steps?.[i] ?? 0;
      say(byId("model-said"), step ? gettext("The ghost is at step {step}", { step }) : "");
    });
  }

  private gotPlan(answer: PlanAnswer): void {
    if (answer.n !== this.planned || !this.plan) return;
    this.plan = { ...this.plan, ok: answer.ok, text: translate(answer.text) };
    this.pick?.answered(answer.ok, this.plan.text, answer.seconds ?? 0);
    if (this.mode?.checked) {
      this.mode.checked(answer);
      return this.page.draw();
    }
    this.view?.refused(!answer.ok);
    const there = answer.joints?.every((q, i) => Math.abs(q - (this.page.state?.joints[i] ?? Infinity)) < THERE) ?? false;
    if (answer.joints && !there) this.view?.target(answer.joints, answer.tool ?? []);
    else this.view?.target(null);
    const way = there
      ? gettext("The arm is there")
      : gettext("{seconds} s on the way", { seconds: answer.seconds === undefined ? "?" : decimals(answer.seconds, 1) });
    say(byId("model-said"), answer.ok ? way : translate(answer.text));
    this.page.draw();
  }

  /** Close (1) or open (0) the gripper; of an arm that follows a hand the motion that is held does it. */
  private grip(closed: number): void {
    if (this.scene?.follows) this.scene.grip(closed);
    else this.page.command("gripper", { closed });
  }

  private goBack(joints: readonly number[]): void {
    this.pick?.clear();
    this.tabs.choose("joint");
    this.joints.put(joints);
  }

  private go(target: Target | null): void {
    if (target) this.start(target);
    else this.page.refuse(() => this.whyNot("go", this.page.facts()));
  }

  /** Send a target; return the number of the command, 0 if it was refused. */
  private start(target: Target, judged = "go"): number {
    const seq = this.page.command(target.kind, target.args, judged);
    if (seq) this.sentTo = { seq, target: JSON.stringify(target) };
    return seq;
  }

  /** Whether the arm is on its way to the target: a second press would only send it once more. */
  private get goesThere(): boolean {
    const { sentTo, page } = this;
    return sentTo !== null && !page.ladder.ended(page.grant, sentTo.seq) && sentTo.target === JSON.stringify(this.target());
  }

  whyNot(kind: string, f: Facts): string {
    const general = blocked(f);
    if (general || (kind === "gripper" && this.scene?.follows)) return general;
    if (kind === "go" && f.busy && this.goesThere) return gettext("The arm is on its way there already.");
    const running = this.page.ladder.motion(this.page.grant, configKinds);
    if (f.busy && running && (kind !== "go" || !replaceable.has(running.kind)))
      return gettext("One command at a time: the arm is still busy.");
    if (this.pick && PICKING.has(kind)) return this.pick.whyNot(kind, this.plan);
    if (kind === "jog" || (kind !== "go" && kind !== this.mode?.asked)) return "";
    const target = this.target();
    if (this.mode?.local) return this.mode.local();
    if (!target) return this.mode?.empty ?? gettext("Fill in every value with a number first.");
    if (this.plan?.key === JSON.stringify(target) && this.plan.text && !this.plan.ok) return this.plan.text;
    return "";
  }

  advice(f: Facts): string {
    return f.busy ? gettext("The arm is busy.") : this.whyNot(this.mode?.asked ?? "jog", f);
  }

  draw(f: Facts): void {
    for (const c of f.snapshot?.commands ?? []) this.prediction.command(c);
    this.goal.draw(this.view);
    byId("modes").hidden = !this.page.operating && !this.page.snapshot?.me.cleared;
    this.showScene();
    for (const [name, kind] of Object.entries(BUTTONS))
      for (const button of document.querySelectorAll<HTMLElement>(`[data-command="${name}"]`)) allow(button, this.whyNot(kind, f));
    this.back.draw();
    for (const mode of [...Object.values(this.modes), this.pick]) mode?.tellRun?.();
    const why = this.whyNot("jog", f);
    for (const one of [this.joints, this.position, this.scene]) one?.enable(why);
  }
}
