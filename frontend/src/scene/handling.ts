/** What hands do with the ghost: where they move it, the arm that follows meanwhile, and what is felt. */
import { Feel } from "../input/feel.ts";
import { Follow } from "../input/follow.ts";
import { Loop, type LoopUse, TICK_MS } from "../input/loop.ts";
import { GamepadSource } from "../input/pads.ts";
import { HandleSource, HoldSource } from "../input/pointer.ts";
import { type Hid, SixAxis } from "../input/six_axis.ts";
import { changeOf, HOME, type Move, type Source, STILL } from "../input/source.ts";
import { Tilt, TouchSource } from "../input/touch.ts";
import { byId, say, set } from "../kit/dom.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { gettext } from "../kit/text.ts";
import type { Pose } from "../motion/chain.ts";
import { missing, turnOf } from "../motion/linear.ts";
import { moved as movedRigid, type Rigid } from "../motion/rigid.ts";
import { facts } from "../page/facts.ts";
import type { RobotPage } from "../page/robot_page.ts";
import { onPress } from "../widgets/jog.ts";
import type { Ghost } from "./ghost.ts";
import { shareOf } from "./moves.ts";

/** The parts of the scene that hands need. */
export interface HandlingUse {
  page: RobotPage;
  ghost: Ghost;
  /** The share of a hand's way that the ghost makes. */
  share(): number;
  /** Change the ghost, and draw it. */
  change(act: () => void): void;
  draw(): void;
  /** Say a sentence until the ghost is moved again. */
  note(text: string): void;
  /** Put the ghost to where the arm is. */
  toArm(): void;
  /** Make the view end a drag. */
  letGo(): void;
  /** Whether what has no place on the page may move the ghost: the focus is there. */
  isHere(): boolean;
}

const KIND = "follow";
const LEVEL = gettext("Here the arm follows a hand only for people with a clearance of a higher level; staff can give it to you.");

export class Handling implements LoopUse {
  readonly handle: HandleSource;
  private hold = new HoldSource();
  private touch: TouchSource;
  private six: SixAxis;
  private pads: GamepadSource;
  private loop: Loop;
  private follow: Follow;
  private feel = new Feel(byId<HTMLInputElement>("feel-on"), byId<HTMLInputElement>("feel-sound"));
  private armed = byId<HTMLInputElement>("follow-on");
  private holding = byId("follow-hold");
  private total: Rigid = HOME; // how far a hand is that tells its place, at the chosen scale
  private start: Pose | null = null; // of the ghost, as the arm began to follow
  private by: Source | null = null; // what moved the ghost last
  private coarse = matchMedia("(pointer: coarse)");

  constructor(private use: HandlingUse) {
    const { page } = use,
      now = (): number => performance.now(),
      hid = (navigator as { hid?: Hid }).hid ?? null;
    this.handle = new HandleSource(() => use.letGo());
    this.six = new SixAxis(hid, () => use.isHere(), () => this.unplugged()); // prettier-ignore
    this.pads = new GamepadSource(byId("ghost-handle"), () => use.isHere());
    const tilt = new Tilt();
    this.touch = new TouchSource(byId("touch-pad"), tilt, () => this.tick());
    this.loop = new Loop([this.hold, this.handle, this.touch, this.pads, this.six], this, now);
    this.follow = new Follow(
      {
        ...page.keepAlive,
        whyNot: () => this.whyNot(),
        begin: (args) => this.begin(args),
        way: () => this.way(),
        over: (why) => this.over(why),
      },
      now,
    );
    this.listen(tilt);
    setInterval(() => this.tick(), TICK_MS);
  }

  private listen(tilt: Tilt): void {
    const { armed, holding } = this;
    armed.addEventListener("click", (event) => {
      if (!refusal(armed)) return;
      event.preventDefault();
      this.use.page.refuse(() => refusal(armed));
    });
    armed.addEventListener("change", () => this.arm());
    const hold = (held: boolean): void => {
      if (held && refusal(holding)) return this.use.page.refuse(() => refusal(holding));
      this.hold.hold(held);
      this.tick();
    };
    onPress(holding, () => hold(true), () => hold(false)); // prettier-ignore
    holding.addEventListener("keydown", (event) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      if (!event.repeat) hold(true);
    });
    holding.addEventListener("keyup", ({ key }) => (key === " " || key === "Enter") && hold(false));
    holding.addEventListener("focusout", () => hold(false));
    for (const name of ["blur", "pagehide"]) addEventListener(name, () => this.drop());
    document.addEventListener("visibilitychange", () => document.hidden && this.drop());
    addEventListener("gamepaddisconnected", () => this.tick());
    byId("six-axis").addEventListener("click", () => void this.six.connect().then((words) => say(byId("six-axis-said"), words)));
    for (const name of ["open", "close"] as const)
      // a second finger makes no click
      for (const button of document.querySelectorAll(`[data-command="${name}"]`))
        button.addEventListener("pointerdown", () => this.grip(name));
    addEventListener("hashchange", layOut);
    layOut();
    const tilts = byId<HTMLInputElement>("tilt-on");
    tilts.addEventListener("change", () => {
      void tilt.use(tilts.checked).then((why) => {
        if (why) tilts.checked = false;
        say(byId("follow-said"), why);
      });
    });
  }

  private arm(): void {
    this.drop();
    say(
      byId("follow-said"),
      this.armed.checked
        ? gettext("From now on the arm follows the ghost while you hold it, or the button below; it holds when you let go.")
        : gettext("The arm follows no more."),
    );
  }

  /** Let the arm follow nobody before the person says so again. */
  disarm(): void {
    this.armed.checked = false;
    say(byId("follow-said"), "");
  }

  /** Whether the arm follows a hand now. */
  get follows(): boolean {
    return this.follow.on;
  }

  /** Read all sources now. */
  tick(): void {
    this.loop.tick();
    this.follow.tick();
  }

  /** Make all hands let go. */
  drop(): void {
    this.loop.drop();
  }

  /** Enable what lets the arm follow, or disable it with a reason. `why`: why no motion may begin now. */
  enable(why: string): void {
    const never = facts.commands.some(({ kind }) => kind === KIND) ? "" : LEVEL;
    allow(this.armed, never);
    byId("follow-level").textContent = never;
    allow(this.holding, this.follow.on ? "" : never || (this.armed.checked ? why : gettext("Tick the box above first.")));
  }

  private whyNot(): string {
    return (
      refusal(this.armed) || this.use.page.whyNot(KIND) || (this.use.ghost.pose ? "" : gettext("It is not known yet where the arm is."))
    );
  }

  private begin(args: Record<string, number>): number {
    const { ghost } = this.use;
    this.use.toArm(); // it is taken afresh, wherever it was
    ghost.take();
    this.total = HOME;
    this.start = ghost.pose && Float64Array.from({ length: 16 }, (_, i) => ghost.pose![i]!);
    return this.use.page.issue(KIND, args);
  }

  private way(): Move {
    const { pose } = this.use.ghost;
    return this.start && pose ? (missing(this.start, pose) as unknown as Move) : STILL;
  }

  private over(why: string): void {
    this.holding.classList.remove("held");
    this.drop();
    this.use.toArm();
    this.use.note(why);
  }

  private unplugged(): void {
    this.tick();
    say(byId("six-axis-said"), gettext("The 6D mouse was unplugged."));
  }

  taken(source: Source): void {
    if (source.isRate) return;
    this.use.note("");
    this.total = HOME;
    this.use.ghost.take();
  }

  held(): void {
    if (!this.armed.checked) return;
    if (this.follow.begin()) this.holding.classList.add("held");
    else this.drop();
  }

  moved(source: Source, by: Move): void {
    this.by = source;
    if (this.follow.on && !this.follow.moved(by)) return;
    const way = shareOf(by, this.use.share()),
      { ghost } = this.use;
    if (source.isRate) return this.use.change(() => ghost.nudge(way));
    this.total = movedRigid(this.total, changeOf(way));
    const { at, turn } = this.total;
    this.use.change(() => ghost.drag([...at, ...turnOf(turn)] as unknown as Move));
  }

  released(source: Source): void {
    if (source.isRate) return;
    this.use.ghost.release();
    this.use.draw();
  }

  letGo(): void {
    this.follow.end();
  }

  grip(grip: "close" | "open"): void {
    this.follow.grip(grip === "close" ? 1 : 0);
  }

  stoodStill(wasUsed: boolean): void {
    if (wasUsed) this.use.note(gettext("The page stood still for a moment, so the ghost was let go: take it again"));
  }

  /** Let the person feel that the ghost has come to a surface, or has snapped. */
  met(touch: "surface" | "snap"): void {
    const isFinger = this.by === this.touch || (this.by === this.handle && this.coarse.matches);
    this.feel.tell(touch, this.by === this.pads ? "gamepad" : isFinger ? "finger" : "other");
  }
}

/** Lay the page out as a controller where its address says so: it is the same page, for the same signed-in person. */
function layOut(): void {
  const isController = location.hash === "#controller",
    link = byId("controller-link");
  document.documentElement.toggleAttribute("data-controller", isController);
  say(link, isController ? gettext("The whole page") : gettext("This page as a controller"));
  set(link, { href: isController ? "#scene" : "#controller" });
}
