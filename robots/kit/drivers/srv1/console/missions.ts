/** The mission card: steps as blocks, as text and by clicks on the map, judged at once, tried on a ghost, sent. */
import { byId, fill, type Judgement, prefetch, type RobotPage, say } from "/static/farhand/v1/console.js";
import { minutes, ProgramDesk } from "/static/farhand/v1/programs.js";
import { ghostAt } from "./mission_ghost.ts";
import { type Judged, judge, type Leg, type Pose } from "./mission_judge.ts";
import { lineOf, parse, print, type Step } from "./mission_text.ts";
import { gettext, ngettext } from "/static/farhand/v1/text.js";

export const MISSION = "mission";
const GHOST_TIMES = 8; // how much faster the ghost is than the rover
const GHOST_MS = 50;

const blocks = (): Promise<typeof import("./mission_blocks.ts")> => import("./mission_blocks.ts");

/** The parts of the page that the card needs. */
interface Around {
  description: Judged;
  /** Where the rover is, or would begin. */
  here(): Pose;
  /** Draw a path (its corners) and the ghost on it; null: none. */
  plan(corners: readonly Pose[] | null, good: boolean): void;
  ghost(at: Pose | null): void;
  /** Send the mission: at once where this person drives, else as a job. */
  send(text: string): void;
}

export class Missions {
  private desk: ProgramDesk<Step>;
  private judged: { legs: Leg[]; said: Judgement[] } = { legs: [], said: [] };
  private steps: readonly Step[] = [];
  private playing = 0;
  private clicks = byId<HTMLInputElement>("mission-clicks");

  constructor(
    private page: RobotPage,
    private around: Around,
  ) {
    const { hall } = around.description;
    this.desk = new ProgramDesk<Step>(page, { parse: (text) => parse(text, hall), print }, gettext("mission"), {
      blocks: async (box, changed) => new (await blocks()).MissionBlocks(box, hall, changed),
      changed: (steps) => this.judge(steps),
      refused: () => this.judge([]),
    });
    prefetch(page, blocks); // so that blocks also work when the connection is lost
    page.on("try", () => this.play());
    page.on("send", () => this.send());
    const card = byId<HTMLDetailsElement>("mission");
    card.addEventListener("toggle", () => {
      if (card.open) void this.desk.open().then(() => this.judge(this.desk.steps));
      else this.around.plan(null, true);
      this.stopGhost();
    });
    for (const [name, step] of Object.entries<Step>({
      photograph: { do: "photograph" },
      read: { do: "read" },
      look: { do: "look" },
      wait: { do: "wait", seconds: 5 },
    }))
      document.querySelector(`[data-add="${name}"]`)?.addEventListener("click", () => this.desk.add(step));
  }

  get open(): boolean {
    return byId<HTMLDetailsElement>("mission").open;
  }

  /** Take a click on the map as a step of the mission. Returns false if it is none. */
  clicked(x: number, y: number, name = ""): boolean {
    if (!this.open || !this.clicks.checked) return false;
    this.desk.add({ do: "go", x, y, name });
    return true;
  }

  /** Return why the mission cannot be sent, apart from the page's own reasons; empty if it can. */
  whyNot(): string {
    if (!this.steps.length) return gettext("Write a mission first: choose blocks, write lines, or click on the map.");
    return this.judged.said.find(({ refuses }) => refuses)?.text ?? ""; // as it is judged: it is shown elsewhere, too
  }

  private judge(steps: readonly Step[]): void {
    this.steps = steps;
    this.stopGhost();
    this.judged = steps.length ? judge(this.around.description, steps, this.around.here()) : { legs: [], said: [] };
    const { legs, said } = this.judged;
    const bad = said.some(({ refuses }) => refuses);
    if (this.open) this.around.plan(legs.length ? legs.flatMap((leg) => leg.poses) : null, !bad);
    this.desk.judge(said);
    let seconds = 0; // before a step, and of the whole mission at the end
    const rows = legs.map((leg) => {
      const row = [String(leg.step), lineOf(steps[leg.step - 1]!), minutes(seconds)];
      seconds += leg.seconds;
      return row;
    });
    fill(byId<HTMLTableElement>("mission-steps").tBodies[0]!, rows);
    if (steps.length && !bad)
      this.desk.tell(
        ngettext("{count} step, about {time}.", "{count} steps, about {time}.", steps.length, { time: minutes(seconds) }),
        "good",
      );
    this.page.draw();
  }

  /** Let the ghost drive the mission on the map. */
  private play(): void {
    this.stopGhost();
    const { legs } = this.judged,
      begun = performance.now();
    this.playing = window.setInterval(() => {
      const at = ghostAt(this.around.description, legs, ((performance.now() - begun) / 1000) * GHOST_TIMES);
      if (at) this.around.ghost(at);
      else this.stopGhost();
    }, GHOST_MS);
  }

  private stopGhost(): void {
    clearInterval(this.playing);
    this.around.ghost(null);
  }

  private send(): void {
    const why = this.whyNot();
    if (why) return this.page.refuse(() => this.whyNot());
    this.around.send(this.desk.text());
  }

  draw(): void {
    say(byId("mission-send"), this.page.operating ? gettext("Run it now") : gettext("Send it as a job"));
    this.desk.enable(this.page.live.lost ? gettext("The connection is lost; what you write stays here.") : "");
    this.desk.follow(this.page.ladder.newest(MISSION));
  }
}
