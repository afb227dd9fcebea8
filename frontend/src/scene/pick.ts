/** Pick and put: a place is chosen by a click in a calibrated camera's picture, its way is shown, and one press goes. */
import { byId, make, say } from "../kit/dom.ts";
import { refusal } from "../kit/refusal.ts";
import { gettext, translate } from "../kit/text.ts";
import { facts } from "../page/facts.ts";
import type { RobotPage } from "../page/robot_page.ts";
import { seenInWords } from "./known.ts";
import type { SceneObjects } from "./objects.ts";
import type { SceneView } from "./view.ts";
import type { CommandInfo } from "../socket/messages.ts";
import type { StatePacket } from "../socket/packets.ts";
import { FINAL } from "../socket/stages.ts";
import type { Cameras } from "../arm/cameras.ts";
import { type Grip, gripInShort, gripInWords, gripOf, type GripperFacts, isLoaded } from "./gripper.ts";
import { type Camera, inPicture, type Place, placeAt, placeInWords } from "./sight.ts";
import type { ArmMode, Target } from "../arm/types.ts";

export interface PickFacts {
  view?: Camera[];
  gripper?: GripperFacts;
  table_m?: number;
  pick_and_put?: { pick: string; put: string; feels: boolean };
}
/** The parts of the console that it needs. */
interface PickUse {
  cameras: Cameras;
  objects: SceneObjects | null;
  /** Ask where the target would lead, after the place or the act has changed. */
  changed(): void;
  /** Send a target. */
  start(target: Target): number;
}
const CHOOSE = gettext("Choose a place in the picture first: click there, or move the cross with the arrow keys.");
type Act = "pick" | "put";

export class Pick implements ArmMode {
  readonly asked = "go-pick";
  readonly empty = CHOOSE;
  private place: Place | null = null;
  private act: Act = "pick";
  private grip: Grip = "unknown";
  private opening = NaN;
  private said = byId("pick-said");
  private badge = make("span", { id: "grip-said" }); // over the picture, beside what the arm does
  private note = ""; // how the last one ended, until a place is chosen
  private way = ""; // why there is none, or that it is not known yet
  private lasts = ""; // how many seconds it takes; empty where there is none
  view: SceneView | null = null;

  /** Return it for a robot that declares it and has cameras for it; null for others. */
  static of(page: RobotPage, told: PickFacts, use: PickUse): Pick | null {
    const kinds = told.pick_and_put,
      offered = kinds && facts.commands.some(({ kind }) => kind === kinds.pick);
    return kinds && offered && told.view?.length && document.getElementById("pick-said") ? new Pick(page, told, kinds, use) : null;
  }

  private constructor(
    private page: RobotPage,
    private told: PickFacts,
    private kinds: Record<Act, string>,
    private use: PickUse,
  ) {
    this.said.parentElement!.hidden = false;
    byId("mode").after(this.badge);
    const { cameras } = use;
    cameras.onPick = (name, at, aspect) => this.choose(name, at, aspect);
    cameras.onShown = () => this.mark();
    cameras.calibrated = (told.view ?? []).map(({ name }) => name);
    byId("screen").addEventListener("keydown", (event) => {
      if (event.key !== "Enter" || event.repeat || !this.place) return;
      event.preventDefault();
      document.querySelector<HTMLElement>('[data-command="go-pick"]')?.click();
    });
    page.on("pick-here", () => this.choice("pick"));
    page.on("put-here", () => this.choice("put"));
    page.on("go-pick", () => {
      const target = this.target();
      if (target && use.start(target)) this.note = "";
    });
  }

  /** Whether a place is chosen, so that the target is this one's. */
  get active(): boolean {
    return this.place !== null;
  }

  target(): Target | null {
    if (!this.place) return null;
    const [x, y] = this.place.at;
    return { kind: this.kinds[this.act], args: { x, y } };
  }

  /** Forget the place: another mode was chosen, or it was done. */
  clear(): void {
    if (!this.place) return;
    this.place = null;
    this.mark();
    this.draw();
  }

  private choose(name: string, at: readonly [number, number], aspect: number): void {
    const camera = this.told.view?.find((one) => one.name === name);
    if (!camera) {
      const cameras = (this.told.view ?? []).map((one) => translate(one.name)).join(", ");
      this.tell(gettext("Choose another camera: {cameras}. In this one's picture no place is known.", { cameras }));
      return;
    }
    const { objects } = this.use;
    const found = placeAt(camera, at, aspect, {
      known: objects?.known ?? [],
      plate: objects?.plate ?? null,
      table: this.told.table_m ?? 0,
    });
    if (!found) {
      this.tell(gettext("There is no table at that place of the picture. Choose a lower one."));
      return;
    }
    this.place = found;
    this.note = "";
    this.act = this.holds ? "put" : "pick";
    this.changed();
  }

  private choice(act: Act): void {
    this.act = act;
    this.changed();
  }

  private tell(note: string): void {
    this.clear();
    this.note = note;
    this.draw();
    this.use.changed();
  }

  private changed(): void {
    this.page.settle();
    this.way = gettext("The way is being checked.");
    this.lasts = "";
    this.mark();
    this.draw();
    this.use.changed();
  }

  private get held(): string {
    return this.use.objects?.known.find(({ held }) => held)?.facts.name ?? "";
  }

  private get holds(): boolean {
    return isLoaded(this.grip, this.held);
  }

  state(packet: StatePacket): void {
    const { gripper } = this.told,
      at = gripper?.joint === undefined ? -1 : facts.names.indexOf(gripper.joint),
      opening = packet.joints[at] ?? NaN;
    if (gripper) this.grip = gripOf(gripper, opening, Number.isNaN(this.opening) ? opening : this.opening);
    this.opening = opening;
    this.draw();
  }

  /** Take over what was answered about the way: it is shown, or there is none. */
  answered(ok: boolean, text: string, seconds: number): void {
    this.way = text;
    this.lasts = ok ? seconds.toFixed(0) : "";
    this.draw();
  }

  /** Return why one of its buttons does not work, where nothing general prevents it; `plan`: that of the way. */
  whyNot(kind: string, plan: { ok: boolean; text: string } | null): string {
    if (!this.place) return CHOOSE;
    if (kind === "pick-here" && this.holds)
      return this.grip === "unknown"
        ? gettext("The gripper should hold something: put it down first.")
        : gettext("The gripper holds something: put it down first.");
    if (kind === "pick-here") return "";
    if (kind === "put-here") return this.holds ? "" : gettext("The gripper holds nothing: pick something up first.");
    return plan?.ok ? "" : plan?.text || gettext("The way is being checked.");
  }

  command(c: CommandInfo): void {
    const mine = Object.values(this.kinds).includes(c.kind);
    if (!mine || !FINAL.has(c.state)) return;
    this.clear();
    this.note = c.state === "completed" ? "" : translate(c.reason);
    this.draw();
  }

  tellRun(): void {
    this.draw();
  }

  /** Return what is done there, or why it is not; Go is named only while it works. */
  private verdict(): string {
    if (!this.lasts) return this.way;
    const told = { act: this.act === "pick" ? gettext("Pick up here") : gettext("Put down here"), seconds: this.lasts };
    return this.page.whyNot("go-pick") ? gettext("{act}: {seconds} s.", told) : gettext("{act}: {seconds} s. Press Go.", told);
  }

  /** Show the place in the picture and in the view. */
  private mark(): void {
    const { cameras } = this.use,
      camera = this.told.view?.find(({ name }) => name === cameras.shownName);
    cameras.mark(this.place && camera ? inPicture(camera, this.place.at, cameras.aspect) : null);
    this.view?.place(this.place?.at ?? null);
  }

  draw(): void {
    const { place, act } = this;
    for (const one of ["pick", "put"] as const)
      document.querySelector(`[data-command="${one}-here"]`)?.setAttribute("aria-pressed", String(place !== null && act === one));
    const next = this.holds ? gettext("Click where to put it down.") : gettext("Click on what to pick up.");
    const grip = gripInWords(this.grip, this.held);
    say(this.badge, gripInShort(this.grip, this.held));
    const chosen = this.use.objects?.known.find(({ facts: { name } }) => name === place?.object),
      seen = chosen ? seenInWords(chosen, this.page.live.now()) : "";
    const where = place && `${placeInWords(place)}${seen && `, ${seen}`}.`;
    say(this.said, [...(where ? [this.verdict(), where] : [this.note || grip, next])].filter(Boolean).join(" "));
    this.said.title = this.said.textContent;
    byId("screen").classList.toggle(
      "refused",
      place !== null && refusal(document.querySelector<HTMLElement>('[data-command="go-pick"]')!) !== "",
    );
  }
}
