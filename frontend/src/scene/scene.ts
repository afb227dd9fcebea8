/** The mode "Scene": the ghost of the tool is put where the tool shall go, planned in the page, and sent as one command. */
import { TargetEdit, type ArmMode, type Target } from "../arm/types.ts";
import { byId, sayLines, set } from "../kit/dom.ts";
import { decimals, gettext, translate } from "../kit/text.ts";
import type { Pose } from "../motion/chain.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { Box } from "../socket/objects.ts";
import type { StatePacket, StreamPacket } from "../socket/packets.ts";
import { Ghost } from "./ghost.ts";
import { Hand, viewButton } from "./hand.ts";
import { Handling } from "./handling.ts";
import type { Judgement, PoseJudge } from "./judge.ts";
import { type Move, numbersOfPose, placeInWords, pointingDown, wayInWords, refusalInWords } from "./moves.ts";
import type { GoalFacts } from "./goals.ts";
import type { ObjectFacts, PlateFacts } from "./known.ts";
import type { SceneObjects } from "./objects.ts";
import { Overlay, type Pictures } from "./overlay.ts";
import { RecordPanel, type TaskText } from "./record_panel.ts";
import { Recorder } from "./recorder.ts";
import { Surroundings } from "./surroundings.ts";
import type { CameraPlace, SceneView } from "./view.ts";

/** What a page may be told for its scene: calibrated cameras, the objects, and the box of their packets. */
export interface SceneFacts {
  view?: CameraPlace[];
  objects?: ObjectFacts[];
  objects_box?: Box;
  plate?: PlateFacts;
  goals?: GoalFacts[];
  table_m?: number;
  release_m?: number; // so far above a surface an object is let go
}
/** The parts of the console that the scene needs. */
export interface SceneUse {
  /** The share of full speed that is chosen. */
  share(): number;
  /** How many numbers of a state are the arm's joints. */
  axes: number;
  /** Show a text over the view. */
  tell(text: string): void;
  /** Send a target; return the number of the command, 0 if it was refused. */
  start(target: Target): number;
  /** Show a motion from rest as expected, which was just sent as the command `seq`; `judged` plans it from joints (rad). */
  sent(seq: number, judged: (from: readonly number[]) => Judgement): void;
  cameras: readonly CameraPlace[];
  /** The objects around the arm, where it tells any. */
  objects: SceneObjects | null;
  /** The cameras' pictures, which may lie behind the scene. */
  pictures: Pictures;
  /** The text of the task mode, where the robot has one. */
  task: TaskText | null;
  /** Show the task mode. */
  showTask(): void;
}

const TELL_MS = 1000; // between two sentences that a screen reader reads
const MOVED_RAD = 0.002; // of a joint: then the way is judged again
const DRAWN_RAD = 1e-5; // then the view is drawn again
const NAMES = ["x", "y", "z", "roll", "pitch", "yaw"];
const REFUSED = new Set(["rejected", "failed", "expired"]); // stages of a command that are said in the view, too
const FREE: Judgement = { verdict: "free", text: "", joints: null, path: [], seconds: NaN };

export class Scene implements ArmMode {
  readonly asked = "go";
  private judge: PoseJudge | null = null;
  private view: SceneView | null = null;
  private surroundings: Surroundings | null;
  private overlay: Overlay | null = null;
  private ghost = new Ghost(
    (pose) => this.judged(pose),
    (pose, from) => this.surroundings?.snap(pose, from) ?? pose,
    (from, to) => this.judge?.along(from, to, this.joints) ?? Float64Array.from(from),
  );
  private edited = new TargetEdit();
  private hand: Hand;
  private handling: Handling;
  private straight = byId<HTMLInputElement>("ghost-straight");
  private scale = byId<HTMLSelectElement>("ghost-scale");
  private list = byId("ghost-list");
  private shown = false;
  private note = ""; // said until the ghost is moved again
  private toldAt = -Infinity;
  private telling = 0;
  private judgedAt: readonly number[] = [];
  private drawnFor: readonly number[] = [];

  constructor(
    private page: RobotPage,
    private use: SceneUse,
  ) {
    this.surroundings = use.objects && new Surroundings(use.objects, () => page.live.now());
    this.hand = new Hand({
      step: (by) => this.step(by),
      home: () => this.home(),
      send: () => this.send(),
      grip: (closed) => this.grip(closed),
      note: (text) => this.say(text),
    });
    this.handling = new Handling({
      page,
      ghost: this.ghost,
      share: () => 1 / Number(this.scale.value),
      change: (act) => this.changed(act),
      draw: () => this.draw(),
      note: (text) => this.say(text),
      toArm: () => this.toArm(),
      letGo: () => this.view?.letGo(),
      isHere: () => this.shown && this.hand.isHere,
    });
    this.straight.addEventListener("change", () => this.again());
    byId("ghost-home").addEventListener("click", () => this.home());
    byId("ghost-down").addEventListener("click", () => this.put((pose) => pointingDown(pose)));
    page.on("send-ghost", () => this.send());
    if (use.objects && use.task)
      new RecordPanel(new Recorder(use.objects), use.task, {
        pose: () => this.ghost.pose,
        put: (pose) => this.put(() => pose),
        changed: () => {
          this.surroundings?.draw();
          this.draw();
        },
        play: (poses) => this.play(poses),
        edit: () => use.showTask(),
      });
  }

  /** Install what judges poses; without it only the server judges, on Send. */
  plan(judge: PoseJudge | null): void {
    this.judge = judge;
    this.follow();
    this.again();
  }

  /** Install the view. */
  attach(view: SceneView): void {
    this.view = view;
    const { handle } = this.handling;
    view.offer({
      taken: () => {
        this.hand.focus();
        handle.take();
        this.handling.tick();
      },
      dragged: (by) => {
        handle.drag(by);
        requestAnimationFrame(() => this.handling.tick());
      },
      released: () => {
        handle.release();
        this.handling.tick();
      },
    });
    this.surroundings?.attach(view);
    const { cameras } = this.use,
      overlay = (this.overlay = cameras.length ? new Overlay(view, this.use.pictures, () => this.page.live.now()) : null);
    byId("viewpoints").append(
      ...Object.entries({ front: gettext("Front"), side: gettext("Side"), top: gettext("Top") }).map(([name, words]) =>
        viewButton(words, () => view.viewpoint(name)),
      ),
      ...cameras.map((camera) =>
        viewButton(gettext("As camera {camera}", { camera: translate(camera.name) }), () => overlay?.look(camera)),
      ),
    );
    const opacity = byId<HTMLInputElement>("arm-opacity");
    opacity.addEventListener("input", () => {
      view.seeThrough(1 - Number(opacity.value) / 100);
      set(opacity, {
        "aria-valuetext": opacity.value === "0" ? gettext("solid") : gettext("{share} % seen through", { share: opacity.value }),
      });
    });
    for (const button of document.querySelectorAll<HTMLElement>("[data-handles]"))
      button.addEventListener("click", () => this.chooseHandles(button));
    this.draw();
  }

  private chooseHandles(chosen: HTMLElement): void {
    for (const button of document.querySelectorAll<HTMLElement>("[data-handles]"))
      set(button, { "aria-pressed": String(button === chosen) });
    this.view?.handleMode(chosen.dataset["handles"] === "rotate" ? "rotate" : "translate");
  }

  /** Show the ghost, or hide it while another mode is open or nobody may use it. */
  show(shown: boolean): void {
    if (shown === this.shown) return;
    this.shown = shown;
    byId("ghost-tools").hidden = !shown;
    if (!shown) {
      this.handling.drop();
      this.view?.ghostAt(null);
    } else {
      this.follow();
      this.again();
    }
  }

  target(): Target | null {
    const { pose } = this.ghost;
    if (!pose || !this.page.state) return null;
    const args: Target["args"] = { speed: this.use.share() };
    numbersOfPose(pose).forEach((value, i) => (args[NAMES[i]!] = value));
    return { kind: this.straight.checked ? "line" : "pose", args };
  }

  /** Return why the ghost cannot be sent; empty if it can, as far as the page knows. */
  local(): string {
    if (!this.ghost.pose) return gettext("It is not known yet where the arm is.");
    const found = this.ghost.judgement;
    return found?.verdict === "way" ? refusalInWords(found.text) : "";
  }

  /** Take over a packet of one of the robot's streams. */
  stream(name: string, packet: StreamPacket): void {
    this.surroundings?.take(name, packet);
    this.draw();
  }

  state(_: StatePacket): void {
    this.follow();
    if (!this.shown) return;
    this.surroundings?.age();
    this.overlay?.draw();
    if (this.ghost.away && !this.follows && this.hasMoved(this.judgedAt, MOVED_RAD)) this.again();
    else if (this.hasMoved(this.drawnFor, DRAWN_RAD)) this.draw();
  }

  private hasMoved(since: readonly number[], rad: number): boolean {
    return this.joints.some((q, i) => Math.abs(q - (since[i] ?? Infinity)) > rad);
  }

  /** Move the ghost through poses of the tool, from where the arm is. Returns why it cannot; empty if it can. */
  private play(poses: readonly Float64Array[]): string {
    const way = this.judge?.through(poses, this.joints, this.use.share()) ?? gettext("The page cannot plan here; try it in task mode.");
    if (typeof way === "string") return way;
    this.view?.play(way.joints.map((q) => [...q, ...(this.page.state?.joints.slice(q.length) ?? [])]), way.tool, () => undefined); // prettier-ignore
    return "";
  }

  /** Let the ghost follow the arm again after that motion, unless somebody has moved it since. */
  arrived(seq: number): void {
    this.edited.arrived(seq);
    if (!this.edited.now && !this.ghost.isHeld) this.home();
  }

  /** Another turn has begun: the arm follows nobody before that person says so. */
  turn(): void {
    this.handling.disarm();
    this.hand.reset();
    this.home();
  }

  /** Take the ghost back to the arm. */
  home(): void {
    this.handling.drop();
    this.note = "";
    this.toArm();
  }

  private toArm(): void {
    this.edited.forget();
    this.ghost.home();
    this.follow();
    this.draw();
  }

  /** Whether the arm follows a hand now. */
  get follows(): boolean {
    return this.handling.follows;
  }

  /** Close (1) or open (0) the gripper of an arm that follows. */
  grip(closed: number): void {
    this.handling.grip(closed ? "close" : "open");
  }

  /** Enable what lets the arm follow, or disable it with a reason. */
  enable(why: string): void {
    this.handling.enable(why);
  }

  /** Judge the ghost's place again: the speed is another, or the arm has moved. */
  again(): void {
    this.ghost.again();
    this.draw();
  }

  private get joints(): readonly number[] {
    return this.page.state?.joints.slice(0, this.use.axes) ?? [];
  }

  private follow(): void {
    this.ghost.follow(this.armPose());
  }

  private armPose(): Pose | null {
    return this.judge && this.joints.length ? this.judge.tool(this.joints) : null;
  }

  private judged(pose: Pose): Judgement {
    this.judgedAt = this.joints;
    return this.judgedFrom(pose, this.joints);
  }

  private judgedFrom(pose: Pose, from: readonly number[]): Judgement {
    const straight = this.straight.checked || this.follows; // an arm that follows needs no plan, and the page no pause
    return this.judge?.judge({ pose, straight, share: this.use.share() }, from) ?? FREE;
  }

  private say(text: string): void {
    this.note = text;
    this.draw();
  }

  private step(by: Move): void {
    this.changed(() => this.ghost.step(by));
  }

  private put(to: (pose: Pose) => Float64Array): void {
    const { pose } = this.ghost;
    if (pose) this.changed(() => this.ghost.put(to(pose)));
  }

  private changed(act: () => void): void {
    const { refusal, snapped } = this.ghost;
    this.note = "";
    this.edited.note(this.page.lastSeq);
    this.page.settle();
    act();
    if (this.ghost.refusal && !refusal) this.handling.met("surface");
    if (this.ghost.snapped && !snapped) this.handling.met("snap");
    this.draw();
  }

  private send(): void {
    if (!this.page.whyNot("go")) this.ghost.moveToGoal((pose) => this.surroundings?.exactPose(pose) ?? pose);
    const target = this.target(),
      { pose } = this.ghost,
      { busy } = this.page.facts();
    if (!target) return this.page.refuse(() => this.local());
    const seq = this.use.start(target);
    if (!seq) return;
    if (pose && !busy) this.use.sent(seq, (from) => this.judgedFrom(pose, from));
    this.page.ladder.whenEnded(this.page.grant, seq, ({ state, reason }) => {
      if (!REFUSED.has(state) || this.ghost.pose !== pose) return; // it was moved since
      this.note = translate(reason);
      this.draw();
    });
  }

  private draw(): void {
    if (!this.shown) return;
    const { pose, judgement, refusal } = this.ghost;
    this.drawnFor = this.joints;
    this.view?.ghostAt(pose, this.ghost.away ? judgement : null, refusal, this.ghost.snapped);
    this.tell(this.words());
    this.fillList();
  }

  private words(): string {
    const { judgement, refusal } = this.ghost;
    if (refusal) return refusalInWords(refusal);
    if (this.note) return this.note;
    if (this.follows) return gettext("The arm follows the ghost");
    if (!this.ghost.pose) return "";
    if (!this.ghost.away) return gettext("The ghost is at the arm");
    if (judgement?.verdict === "way") return refusalInWords(judgement.text);
    return judgement && Number.isFinite(judgement.seconds)
      ? gettext("{seconds} s on the way", { seconds: decimals(judgement.seconds, 1) })
      : gettext("The server checks the way on Send");
  }

  private fillList(): void {
    const { pose } = this.ghost,
      arm = this.armPose();
    const words = !pose
      ? [gettext("It is not known yet where the arm is.")]
      : [
          this.ghost.away
            ? gettext("From the arm: {way}.", { way: (arm && wayInWords(arm, pose)) || gettext("less than half a millimetre") })
            : gettext("The ghost is at the arm."),
          gettext("Place: {place}.", { place: placeInWords(pose) }),
          ...[this.surroundings?.words(pose) ?? ""].filter(Boolean),
          ...(this.ghost.away || this.ghost.refusal || this.note ? [`${this.words().replace(/\.$/, "")}.`] : []),
        ];
    sayLines(this.list, words);
  }

  /** Tell a sentence, at most one a second; the newest counts. */
  private tell(text: string): void {
    clearTimeout(this.telling);
    const wait = Math.max(0, this.toldAt + TELL_MS - performance.now());
    const now = (): void => {
      if (!this.shown) return;
      this.toldAt = performance.now();
      this.use.tell(text);
    };
    if (wait) this.telling = window.setTimeout(now, wait);
    else now();
  }
}
