/** The console of a rover in a hall: camera, map, readings; driven by hand or sent to a place. */
import {
  allow,
  Basics,
  byId,
  type CommandInfo,
  type Facts,
  facts,
  fill,
  FINAL,
  make,
  PlaceForm,
  RecentPlaces,
  RobotPage,
  type StatePacket,
  type StreamPacket,
} from "/static/farhand/v1/console.js";
import { DrivePad, JobPanel } from "/static/farhand/v1/roaming.js";
import "./console.css";
import { HallInDepth } from "./hall_in_depth.ts";
import { type Description, HallMap } from "./hall_map.ts";
import { HistoryPart, type Reading } from "./history_part.ts";
import type { Judged, Pose } from "./mission_judge.ts";
import { MISSION, Missions } from "./missions.ts";
import type { Made } from "./rules_check.ts";
import { RulesPanel } from "./rules_panel.ts";
import { StickPart } from "./stick_part.ts";
import { UnseenPart } from "./unseen_part.ts";
import { decimals, gettext, translate } from "/static/farhand/v1/text.js";

const GO = "go";
const TURN_RAD = Math.PI / 2;
const HISTORY: readonly Reading[] = [
  { channel: "infrared", name: gettext("Ahead, by infrared"), words: (v) => `${(100 * v).toFixed(0)} cm`, least: 0.2 },
  { channel: "sonar", name: gettext("Ahead, by sonar"), words: (v) => `${decimals(v, 2)} m`, least: 1 },
  { channel: "spread", name: gettext("Sure of its place"), words: (v) => within(v), least: 0.1 },
  { channel: "battery", name: gettext("Battery"), words: (v) => `${decimals(v, 2)} V`, least: 0.5 },
  { channel: "temperature", name: gettext("Temperature"), words: (v) => `${decimals(v, 1)} °C`, least: 2 },
  { channel: "humidity", name: gettext("Humidity"), words: (v) => `${v.toFixed(0)} %`, least: 10 },
  { channel: "light", name: gettext("Light"), words: (v) => `${v.toFixed(0)} %`, least: 20 },
];
const HOW = gettext("Click on the floor of the map, or choose a place here.");
type Values = Record<string, number | string>;
const description = facts as typeof facts & Description & Judged & Made & { hall: { home: Pose } };
const page = new RobotPage();

class HallConsole extends Basics<RobotPage> {
  private map = new HallMap(byId<SVGSVGElement>("hall"), description, (x, y) => this.picked(round(x), round(y)));
  private deep = new HallInDepth(page, byId("hall-3d"), byId<HTMLButtonElement>("deep"), description, (x, y) =>
    this.picked(round(x), round(y)),
  );
  private missions = new Missions(page, {
    description,
    here,
    send: (text) => this.sendMission(text),
    plan: (corners, good) => [this.map, this.deep].forEach((view) => view.plan(corners, good)),
    ghost: (at) => [this.map, this.deep].forEach((view) => view.ghost(at)),
  });
  private unseen = new UnseenPart(byId<SVGSVGElement>("hall"), this.map.first);
  private pad = new DrivePad(page, byId("drive"), false); // the stick in it takes gamepads, by degrees
  private stick = new StickPart(page, description, byId("drive"));
  private history = new HistoryPart(page, HISTORY, byId("readings"));
  private places: HTMLButtonElement[] = [];
  private recent = new RecentPlaces(byId("recent"), ["x", "y"], ([x = 0, y = 0]) => where({ x, y }, GO), ([x = 0, y = 0]) => this.picked(x, y)); // prettier-ignore
  private fields: PlaceForm;
  private jobs: JobPanel;
  private rules = new RulesPanel(page, description);
  private sent: readonly [number, number] | null = null; // where this page's driver has sent it

  constructor() {
    super(page);
    const words = {
      kind: GO,
      noun: gettext("place"),
      how: HOW,
      where,
      others: { [MISSION]: { noun: gettext("mission"), done: gettext("carried out") } },
    };
    this.jobs = new JobPanel(page, words, () => this.mark());
    for (const { name, at } of description.hall.node) this.listPlace(name, ...at);
    const { width, depth } = description.hall;
    this.fields = new PlaceForm(
      byId<HTMLFormElement>("place-form"),
      Object.entries({ x: width, y: depth }).map(([name, high]) => ({ name, unit: "m", per: 1, low: 0, high })),
      ([x = 0, y = 0]) => this.picked(round(x), round(y)),
      (why) => page.refuse(why),
    );
    for (const name of ["patrol", "look"]) page.on(name, () => page.command(name));
    page.on("left", () => page.command("turn", { angle: TURN_RAD }));
    page.on("right", () => page.command("turn", { angle: -TURN_RAD }));
  }

  private listPlace(name: string, x: number, y: number): void {
    const button = make("button", { type: "button", class: "button" }, translate(name));
    button.addEventListener("click", () => this.picked(x, y, name));
    byId("spots").append(make("li", {}, button));
    this.places.push(button);
  }

  /** Take a chosen place: as a step of the mission that is being written, or to send the rover there. */
  private picked(x: number, y: number, name = ""): void {
    if (!this.missions.clicked(x, y, name)) this.send(x, y);
  }

  /** Send the text that is shown, also of a saved mission, because that may have changed since it was loaded. */
  private sendMission(text: string): void {
    if (page.operating) page.command(MISSION, { text });
    else void this.jobs.ask({ text }, MISSION);
  }

  /** Send the rover there at once if the person drives; otherwise ask for it as a job. */
  private send(x: number, y: number): void {
    if (!page.operating) return void this.jobs.ask({ x, y });
    if (page.command(GO, { x, y })) this.sent = [x, y];
    this.mark();
  }

  private whyNotSend(): string {
    return page.operating ? page.whyNot(GO) : this.jobs.whyNot();
  }

  override state(packet: StatePacket): void {
    super.state(packet);
    const told = (name: string): number | undefined => page.value(name);
    const [x, y, heading] = [told("x"), told("y"), told("heading")];
    const known = x !== undefined && y !== undefined && heading !== undefined;
    this.deep.show(known ? [x, y, heading] : null);
    const [spread = 0, infrared = 0, sonar = 0] = [told("spread"), told("infrared"), told("sonar")];
    this.map.show(known ? { x, y, heading, spread, infrared, sonar } : null);
    readings();
    this.rules.state();
    this.stick.state();
    this.history.draw(packet.atMs);
  }

  stream(name: string, packet: StreamPacket): void {
    if (name === "unseen") this.unseen.take(packet);
  }

  override command(c: CommandInfo): void {
    if (c.grant === page.grant) this.recent.take(c);
    if (c.kind === GO && FINAL.has(c.state)) this.sent = null;
    this.mark();
  }

  override turn(): void {
    this.sent = null;
    this.recent.forget();
  }

  /** Mark the place to which the rover drives. */
  private mark(): void {
    // eslint-disable-next-line @typescript-eslint/no-unnecessary-condition -- the panel itself calls this first while it is made
    const job = this.jobs?.open.find(({ job: { kind, state } }) => kind === GO && state === "running")?.job.args;
    const to = page.target?.place ?? job; // of who drives, or of a job
    const at = this.sent ?? (to ? ([Number(to["x"]), Number(to["y"])] as const) : null);
    for (const view of [this.map, this.deep]) view.mark(at);
  }

  override draw(f: Facts): void {
    this.jobs.draw();
    this.mark();
    this.rules.draw();
    const why = this.whyNotSend();
    for (const button of this.places) allow(button, why);
    this.fields.enable(why);
    this.recent.enable(why);
    byId("recent").hidden = byId("recent-head").hidden = !page.operating;
    this.missions.draw();
    allow(byId("mission-send"), (page.operating ? page.whyNot(MISSION) : this.jobs.whyNot()) || this.missions.whyNot());
    this.pad.draw(this.whyNot("drive", f));
    this.stick.enable(this.whyNot("drive", f));
    for (const [name, kind] of Object.entries({ patrol: "patrol", look: "look", left: "turn", right: "turn" }))
      allow(document.querySelector<HTMLElement>(`[data-command="${name}"]`)!, this.whyNot(kind, f));
  }
}

function round(metres: number): number {
  return Math.round(metres * 100) / 100;
}

function within(metres: number): string {
  return gettext("within {cm} cm", { cm: (100 * metres).toFixed(0) });
}

/** Return where the rover is; its home while that is not known. */
function here(): Pose {
  const [x, y, heading] = ["x", "y", "heading"].map((name) => page.value(name));
  return x === undefined || y === undefined || heading === undefined ? description.hall.home : [x, y, heading];
}

/** Return a place in words: its name if it has one. */
function where(args: Values, kind: string): string {
  if (kind === MISSION) return gettext("a mission");
  const [x, y] = [Number(args["x"]), Number(args["y"])];
  const node = description.hall.node.find(({ at }) => Math.hypot(at[0] - x, at[1] - y) < 0.05);
  return node ? translate(node.name) : gettext("{x} m from the left, {y} m from below", { x: decimals(x, 1), y: decimals(y, 1) });
}

/** Show the rover's values in words. */
function readings(): void {
  const told = (name: string, words: (value: number) => string): string => {
    const value = page.value(name);
    return value === undefined ? gettext("not known") : words(value);
  };
  const far = description.infrared.far;
  fill(byId("readings").querySelector("tbody")!, [
    [gettext("Now"), page.state?.mode ? translate(page.state.mode) : gettext("not known")],
    [
      gettext("Ahead, by infrared"),
      told("infrared", (v) => (v < far - 0.005 ? `${(100 * v).toFixed(0)} cm` : gettext("nothing within 80 cm"))),
    ],
    [gettext("Ahead, by sonar"), told("sonar", (v) => `${decimals(v, 2)} m`)],
    [gettext("Looks"), told("compass", (v) => gettext("{degrees}° from north, clockwise", { degrees: v.toFixed(0) }))],
    [gettext("Sure of its place"), told("spread", (v) => (v > 1 ? gettext("not known: let it look around") : within(v)))],
    [gettext("Battery"), told("battery", (v) => `${decimals(v, 2)} V`)],
    [gettext("Temperature"), told("temperature", (v) => `${decimals(v, 1)} °C`)],
    [gettext("Humidity"), told("humidity", (v) => `${v.toFixed(0)} %`)],
    [gettext("Light"), told("light", (v) => `${v.toFixed(0)} %`)],
    [gettext("Visitors near it"), told("presence", (v) => (v >= 0.5 ? gettext("yes") : gettext("no")))],
    [gettext("Driven"), told("driven", (v) => `${decimals(v, 1)} m`)],
  ]);
}

page.begin(new HallConsole());
