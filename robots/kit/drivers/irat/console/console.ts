/** The iRat's console: camera, map, pose cells; everybody's goals by a click or from a list of places. */
import type { CellGrid } from "/static/farhand/v1/cells.js";
import { allow, Basics, byId, type Facts, fill, RobotPage, say, type StatePacket, type StreamPacket } from "/static/farhand/v1/console.js";
import { DrivePad, GraphMap, JobPanel, landmarks, type Mark, SpotList, whereabouts } from "/static/farhand/v1/roaming.js";
import { ACROSS, HEADINGS, LEVELS, PoseCells } from "./cell_packets.ts";
import { type Earlier, earlierOf, endOf } from "./earlier_map.ts";
import { ExperienceMap } from "./map_packets.ts";
import { decimals, gettext, language, translate } from "/static/farhand/v1/text.js";

const GOAL = "goal";
const LETTERS_MS = 1000; // between two choices of lettered places
const NO_PLACE = gettext("The robot knows no place there. Click on one of the dots, or use the list of places.");
const AT_DOCK = gettext("This place is at the dock, where the robot goes only to charge. Choose one farther away from it.");
const NOW = gettext("Show the map of now"),
  PAST = gettext("This is an earlier map, where the robot cannot be sent. Press “{button}” first.", { button: NOW });
const HOW = gettext("Click on a dot of the map, or choose a place here; you need no account.");
const OWN_BUTTONS = ["explore", "charge", "clear_map"];
type Values = Record<string, number | string>;
const page = new RobotPage();

class RoamingConsole extends Basics<RobotPage> {
  private known = new ExperienceMap();
  private whole = { map: false, cells: false };
  private earlier: Earlier | null = null;
  private last = 0; // the number of the map before this one
  private past = false; // whether the earlier map is shown
  private told = 0; // the number of the earlier map whose end was said
  private target = 0; // the command whose target is marked
  private cells = new PoseCells();
  private grid: CellGrid | null = null;
  private letters = new Map<string, number>();
  private letteredAt = 0;
  private map = new GraphMap(byId<HTMLCanvasElement>("map"), (place) =>
    this.past ? page.refuse(() => (this.past ? PAST : "")) : this.picked(place),
  );
  private goals: JobPanel;
  private list: SpotList;
  private pad = new DrivePad(page, byId("drive"));
  private wide = matchMedia("(min-width: 600px)");

  constructor() {
    super(page);
    const words = { kind: GOAL, noun: gettext("goal"), how: HOW, where: (args: Values) => this.where(args) };
    this.goals = new JobPanel(page, words, () => this.marks());
    this.list = new SpotList(byId("spots"), (place) => this.picked(place));
    byId("earlier-show").addEventListener("click", () => this.turnBack(!this.past));
    for (const name of OWN_BUTTONS) page.on(name, () => page.command(name));
    this.wide.addEventListener("change", () => void this.openCells());
    void this.openCells();
  }

  /** Load and show the pose cells, except on a phone. */
  private async openCells(): Promise<void> {
    byId("cells-view").hidden = !this.wide.matches;
    if (!this.wide.matches || this.grid) return;
    try {
      const { CellGrid } = await import("/static/farhand/v1/cells.js");
      this.grid ??= new CellGrid(byId("cells"), [ACROSS, ACROSS, HEADINGS], LEVELS);
      this.grid.show(this.cells.levels);
    } catch (error) {
      byId("cells-view").hidden = true;
      console.warn(error);
    }
  }

  override state(packet: StatePacket): void {
    super.state(packet);
    const [x, y, heading] = ["x", "y", "heading"].map((name) => page.value(name));
    const known = x !== undefined && y !== undefined && heading !== undefined && !this.past;
    this.map.place(known ? { x, y, heading } : null);
    showReadings();
  }

  stream(name: string, { data, key }: StreamPacket): void {
    if (name === "cells") {
      this.whole.cells = (key || this.whole.cells) && this.cells.take(data, key);
      this.grid?.show(this.cells.levels);
    } else if (name === "map") {
      const before = this.known.number;
      this.whole.map = (key || this.whole.map) && this.known.take(data, key);
      if (this.known.number !== before) this.last = before;
      if (!this.past) this.map.show(this.known, this.known.number !== before);
      this.marks();
    } else if (name === "earlier") this.ended(earlierOf(data));
  }

  /** Say that a map was cleared, and offer to show it. */
  private ended(earlier: Earlier | null): void {
    if (!earlier) return;
    this.earlier = earlier;
    const words = endOf(earlier, timeOf(earlier.endedMs));
    say(byId("earlier-said"), words);
    byId("earlier").hidden = false;
    byId("earlier-show").hidden = !earlier.map.spots.size;
    const fresh = earlier.map.number !== this.told && [this.known.number, this.last].includes(earlier.map.number);
    if (fresh) page.notice(words, "info");
    this.told = earlier.map.number;
    if (this.past) this.turnBack(earlier.map.spots.size > 0);
  }

  /** Show the earlier map, or the present one. */
  private turnBack(past: boolean): void {
    this.past = past && this.earlier !== null;
    say(byId("earlier-show"), this.past ? NOW : gettext("Show the earlier map"));
    byId("map-how").style.visibility = this.past ? "hidden" : ""; // it keeps its height
    this.map.show(this.past ? this.earlier!.map : this.known, true);
    this.map.place(null);
    this.marks();
  }

  /** Draw the letters of well-spread places and the marks of goals; both move with the map. */
  private marks(): void {
    const { spots } = this.known;
    this.target = page.target?.id ?? 0;
    if (performance.now() - this.letteredAt > LETTERS_MS) {
      this.letteredAt = performance.now();
      this.letters = landmarks(this.letters, this.known.open());
      this.list.show([...this.letters].map(([letter, id]) => ({ letter, id, words: whereabouts(spots.get(id)!, spots) })));
    }
    const marks = this.goals.open.flatMap(({ job, own }): Mark[] => {
      const at = this.placeOf(job.args);
      return at ? [{ ...at, text: String(job.ahead), own, now: job.state === "running" }] : [];
    });
    const { x, y } = page.target?.place ?? {}; // of a command that is no job
    if (x !== undefined && y !== undefined && !marks.some(({ now }) => now)) marks.push({ x, y, text: "", own: false, now: true });
    const labels = [...this.letters].flatMap(([letter, id]) => {
      const at = spots.get(id);
      return at ? [[letter, at] as const] : [];
    });
    if (this.past) this.map.mark([], new Map());
    else this.map.mark(marks, new Map(labels));
    const now = spots.size ? "" : gettext("No map yet: it grows as the robot drives.");
    say(byId("map-said"), this.past ? gettext("Earlier map, number {number}", { number: this.earlier!.map.number }) : now);
  }

  /** Return where a goal lies on this map; undefined if it belongs to another map. */
  private placeOf(args: Values): { x: number; y: number } | undefined {
    if (Number(args["map"]) !== this.known.number) return undefined;
    return this.known.spots.get(Number(args["experience"])) ?? { x: Number(args["x"]), y: Number(args["y"]) };
  }

  private where(args: Values): string {
    const at = this.placeOf(args);
    if (!at) return gettext("on a map that was cleared");
    const letter = [...this.letters].find(([, id]) => id === Number(args["experience"]))?.[0];
    return `${letter ? `${letter}, ` : ""}${whereabouts(at, this.known.spots)}`;
  }

  private picked(place: number | null): void {
    const at = place === null ? undefined : this.known.spots.get(place);
    if (!at || place === null) return page.refuse(() => NO_PLACE);
    if (!this.known.open().has(place)) return page.refuse(() => AT_DOCK);
    void this.goals.ask({ map: this.known.number, x: round(at.x), y: round(at.y), experience: place });
  }

  override draw(f: Facts): void {
    this.goals.draw();
    if ((page.target?.id ?? 0) !== this.target) this.marks();
    this.list.enable(this.goals.whyNot());
    this.pad.draw(this.whyNot("drive", f));
    for (const name of OWN_BUTTONS) {
      const button = document.querySelector<HTMLElement>(`[data-command="${name}"]`)!;
      button.hidden = !page.operating;
      allow(button, this.whyNot(name, f));
    }
  }
}

/** Show the robot's values in words. */
function showReadings(): void {
  const told = (name: string, words: (value: number) => string): string => {
    const value = page.value(name);
    return value === undefined ? gettext("not known") : words(value);
  };
  const charge = page.value("charge");
  byId<HTMLMeterElement>("charge").value = charge ?? 0;
  say(
    byId("charge-said"),
    gettext("Battery {charge}, {voltage}", {
      charge: told("charge", (v) => `${v.toFixed(0)} %`),
      voltage: told("battery", (v) => `${decimals(v, 1)} V`),
    }),
  );
  fill(byId("readings").querySelector("tbody")!, [
    [gettext("Now"), page.state?.mode ? translate(page.state.mode) : gettext("not known")],
    [gettext("Charging"), told("charging", (v) => (v > 0 ? gettext("yes, current flows") : gettext("no")))],
    [gettext("Remembered places"), told("experiences", (v) => v.toFixed(0))],
    [gettext("Map"), told("map", (v) => gettext("number {number}", { number: v.toFixed(0) }))],
    [gettext("Dock seen from"), told("docks", (v) => gettext("{count} places", { count: v.toFixed(0) }))],
    [gettext("Driven"), told("driven", (v) => `${decimals(v, 1)} m`)],
  ]);
}

function timeOf(ms: number): string {
  return new Intl.DateTimeFormat(language(), { dateStyle: "medium", timeStyle: "short", hourCycle: "h23" }).format(new Date(ms));
}

function round(metres: number): number {
  return Math.round(metres * 1000) / 1000;
}

page.begin(new RoamingConsole());
