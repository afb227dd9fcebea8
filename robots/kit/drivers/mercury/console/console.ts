/** The console of an arm with a camera and an air jet over sand: a picture and a map to click. */
import {
  allow,
  Basics,
  blocked,
  byId,
  CameraView,
  type CommandInfo,
  DugMap,
  facts,
  type Facts,
  GoBack,
  Jog,
  make,
  PlaceForm,
  RecentPlaces,
  RobotPage,
  say,
  type StatePacket,
  stick,
  type Still,
} from "/static/farhand/v1/console.js";
import "./console.css";
import { type SandFacts, whyNot } from "./rules.ts";
import { type Description, forward, type Map2, nozzlePixel, onSand, pixel, target } from "./scara.ts";
import { Schematic } from "./schematic.ts";
import { gettext } from "/static/farhand/v1/text.js";

type Aim = { by: "camera"; u: number; v: number; still: number } | { by: "map"; x: number; y: number };

const description = facts as typeof facts & Description;
const page = new RobotPage();
const MM = 1000;
const NOT_YET = gettext("You cannot click in this picture yet: the arm moves, or the picture was not stored. Wait for the next one.");

class SandConsole extends Basics<RobotPage> {
  private aim: Aim | null = null;
  private sent: Aim | null = null;
  private airStill = 0;
  private jog: Jog<readonly [number, number]>;
  private back = new GoBack(page, {
    kinds: ["move", "click"],
    joints: 2,
    whyNot: () => this.whyNot("back", page.facts()),
    choose: (joints) => this.pickPoint(...forward(description, [...joints]).tool),
  });
  private recent = new RecentPlaces(byId("recent"), ["x", "y"], inMm, ([x = 0, y = 0]) => this.pickPoint(x, y));
  private schematic = new Schematic(byId<SVGSVGElement>("schematic"), description, (x, y) => this.pickPoint(x, y));

  private dug = new DugMap(page, this.schematic.dug, byId("schematic").dataset["dug"], MM);

  constructor() {
    const { sand } = description;
    const [picture, overlay] = [byId<HTMLCanvasElement>("picture"), byId<SVGSVGElement>("overlay")];
    super(page, new CameraView(byId("screen"), picture, overlay, (u, v) => this.pickPixel(u, v)));
    page.on("go", () => this.go());
    for (const kind of ["up", "down", "air"]) page.on(kind, () => this.give(kind));
    const axes = (["x", "y"] as const).map((name) => ({ name, unit: "mm", per: MM, low: sand[name][0], high: sand[name][1] }));
    new PlaceForm(byId<HTMLFormElement>("place-form"), axes, ([x = 0, y = 0]) => this.pickPoint(x, y), (why) => page.refuse(why)); // prettier-ignore
    for (const label of byId("jog").querySelectorAll("[data-step]")) say(label, `${MM * description.jog.step} mm`);
    byId("stage").addEventListener("keydown", (event) => this.key(event));
    this.jog = new Jog(byId("jog"), {
      read: (words) => {
        const [x = 0, y = 0] = words.split(",").map(Number);
        return [x, y];
      },
      arrows: { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] },
      stick,
      whyNot: () => this.whyNot("jog", page.facts()),
      begin: ([dx, dy]) => {
        this.given();
        return page.issue("jog", { dx, dy });
      },
      ...page.keepAlive,
    });
  }

  override state(packet: StatePacket): void {
    this.schematic.joints(packet.joints);
  }

  override still(still: Still): void {
    this.schematic.covers(still, mapFor(still));
    this.schematic.joints(page.state?.joints ?? still.joints);
    this.camera.still(still, () => page.draw());
  }

  override watch(): void {
    this.dug.load();
  }

  override turn(): void {
    this.aim = null;
    this.recent.forget();
    if (page.operating) this.dug.load(); // a new round may have begun
  }

  override command(c: CommandInfo): void {
    if (c.grant === page.grant) this.recent.take(c);
    const still = page.snapshot?.still;
    if (c.state === "completed" && c.kind === "air") {
      if (still) this.airStill = still.id;
      if (page.state) this.dug.add(c.id, ...forward(description, page.state.joints).tool);
    }
    if (c.state === "completed" && this.aim === this.sent) this.aim = null;
  }

  private pickPixel(u: number, v: number): void {
    if (!page.operating) return;
    if (this.camera.stillId === 0) return page.refuse(() => (this.camera.stillId ? "" : NOT_YET));
    this.choose({ by: "camera", u, v, still: this.camera.stillId });
  }

  private choose(aim: Aim): void {
    this.aim = aim;
    page.settle();
    page.draw();
  }

  private pickPoint(x: number, y: number): void {
    if (!page.operating) return;
    this.choose({ by: "map", x, y });
  }

  private aimPoint(): [number, number] | null {
    if (!this.aim) return null;
    if (this.aim.by === "map") return [this.aim.x, this.aim.y];
    const still = page.snapshot?.still;
    const map = still ? mapFor(still) : null;
    return still && map ? target(map, still.pose, this.aim.u, this.aim.v, still.width, still.height) : null;
  }

  private aimState(): SandFacts["aim"] {
    if (!this.aim) return "none";
    if (this.aim.by === "camera" && this.aim.still !== page.snapshot?.still?.id) return "old";
    const at = this.aimPoint();
    return at && onSand(description, ...at) ? "good" : "refused";
  }

  private judged(f: Facts): SandFacts {
    return { ...f, blocked: blocked(f), aim: this.aimState() };
  }

  override whyNot(kind: string, f: Facts): string {
    return whyNot(kind, this.judged(f));
  }

  override advice(f: Facts): string {
    const why = f.busy ? gettext("The arm is busy.") : this.whyNot("go", f);
    const at = why ? null : this.aimPoint();
    if (why || !at) return why;
    const dug = this.dug.words(...at);
    return dug ? gettext("Enter or “Move here” sends the arm: {dug}.", { dug }) : gettext("Enter or “Move here” sends the arm.");
  }

  private give(kind: string): void {
    if (!this.whyNot(kind, page.facts())) this.given();
    page.command(kind);
  }

  /** Forget a chosen place that was refused, or that another command than "go" makes wrong. */
  private given(): void {
    if (this.aim?.by === "camera" || this.aimState() === "refused") this.aim = null;
  }

  private go(): void {
    const { aim } = this;
    if (!aim) return page.refuse(() => this.whyNot("go", page.facts()));
    this.sent = aim;
    if (aim.by === "camera") page.command("click", { still: aim.still, u: aim.u, v: aim.v }, "go");
    else page.command("move", { x: aim.x, y: aim.y }, "go");
  }

  private key(event: KeyboardEvent): void {
    const field = (event.target as HTMLElement).closest("input, textarea, select, button, a");
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey || field || !page.operating) return;
    const acts: Record<string, () => void> = {
      up: () => this.give("up"),
      down: () => this.give("down"),
      air: () => this.give("air"),
    };
    const act = event.key === "Enter" ? () => this.go() : acts[page.keyAction(event)];
    if (!act) return;
    event.preventDefault();
    act();
  }

  override draw(f: Facts): void {
    const judged = this.judged(f);
    const z = f.state?.joints[2];
    sayHeight(byId("height"), z);
    byId("jog").hidden = !page.operating;
    this.jog.enable(whyNot("jog", judged));
    byId("back").hidden = byId("places").hidden = !page.operating;
    this.back.draw();
    for (const name of ["go", "up", "down", "air"]) {
      const button = document.querySelector<HTMLElement>(`[data-command="${name}"]`);
      if (button) allow(button, whyNot(name, judged));
    }
    this.drawAim(judged);
    this.drawBefore();
  }

  private drawAim(f: SandFacts): void {
    const still = page.snapshot?.still ?? null;
    const map = still ? mapFor(still) : null;
    const watched = targetPlace();
    this.schematic.aim(page.operating ? this.aimPoint() : watched);
    // the camera is on the arm, so cross and nozzle belong to the picture for which they were computed
    const shown = this.camera.stillId;
    const fits = still?.id === shown && map ? map : null;
    const from = still && fits && (page.operating || watched) ? nozzlePixel(fits, still.width, still.height) : null;
    const own: [number, number] | null =
      this.aim?.by === "camera" && this.aim.still === shown && f.aim !== "old" ? [this.aim.u, this.aim.v] : null;
    const theirs = still && fits && watched ? pixel(fits, still.pose, watched, still.width, still.height) : null;
    this.camera.aim(own ?? theirs, from);
    byId("screen").classList.toggle("refused", f.aim === "refused");
  }

  private drawBefore(): void {
    const box = byId("before");
    const { before, still } = page.snapshot ?? {};
    const after = page.snapshot?.commands.find((c) => c.result?.still === still?.id);
    const show = Boolean(before && still && after?.kind === "air");
    box.hidden = !show;
    if (!show || !before || !still || this.airStill === -still.id) return;
    byId<HTMLImageElement>("before-picture").src = before.url;
    byId<HTMLImageElement>("after-picture").src = still.url;
    this.airStill = -still.id;
  }
}

/** Say how high the camera is: down, or so far above that. The paper's name of it stands beside, small. */
function sayHeight(badge: HTMLElement, z: number | undefined): void {
  const up = z === undefined ? 0 : Math.round(z * 1000);
  const words = z === undefined ? "" : z < 0.001 ? gettext("Lowered") : gettext("{mm} mm up", { mm: up });
  if (badge.dataset["words"] === words) return;
  badge.dataset["words"] = words;
  badge.replaceChildren(...(words ? [`${words} `, make("small", {}, `Z = ${up}`)] : []));
}

/** Return a place in words. */
function inMm(place: readonly number[]): string {
  return `${place
    .map((v) => Math.round(v * MM))
    .join(", ")
    .replaceAll("-", "−")} mm`;
}

/** Return the place (m) to which the driver has sent the arm, for who watches. */
function targetPlace(): [number, number] | null {
  const { x, y } = page.target?.place ?? {};
  return x === undefined || y === undefined ? null : [x, y];
}

function mapFor(still: Still): Map2 | null {
  const z = still.pose[2] ?? 0;
  const measured = Object.values(still.calibration) as (Map2 & { z: number })[];
  return measured.find((e) => Math.abs(e.z - z) < 0.005) ?? null;
}

page.begin(new SandConsole());
