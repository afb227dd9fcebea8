/** The panel of what can be won: the figure in the view, what is missing in words, and a win, which is said once. */
import { byId, say, sayLines } from "../kit/dom.ts";
import { timeOfDay } from "../kit/times.ts";
import { gettext } from "../kit/text.ts";
import { type GoalFacts, newlyWon, partsInWords, progress, type Reached } from "./goals.ts";
import type { KnownObject } from "./known.ts";
import type { SceneObjects } from "./objects.ts";
import type { SceneView } from "./view.ts";

export class GoalPanel {
  private shown = byId<HTMLInputElement>("goals-shown");
  private told: Record<string, Reached> | null = null;
  view: SceneView | null = null;

  constructor(private objects: SceneObjects) {
    byId("scene-goals").hidden = !objects.goals.length;
    this.shown.addEventListener("change", () => this.draw());
  }

  draw(): void {
    const { goals, reached } = this.objects;
    if (!goals.length) return;
    const all = this.objects.known,
      now = reached ?? {},
      figures = this.figures;
    say(byId("goals-count"), figures.map((goal) => gettext("figure {progress}", { progress: progress(goal, now[goal.name]) })).join(", "));
    sayLines(byId("goals-list"), [
      ...figures.slice(0, 1).flatMap((goal) => partsInWords(goal, all, now[goal.name])),
      ...goals.map((goal) => `${goal.title}: ${wonInWords(now[goal.name])}`),
    ]);
    this.view?.goal(this.shown.checked ? this.missing(all, now) : []);
    if (reached) this.announce(reached);
  }

  private get figures(): GoalFacts[] {
    return this.objects.goals.filter(({ kind }) => kind === "build");
  }

  /** Return the parts that are not there, where they belong. */
  private missing(all: readonly KnownObject[], now: Record<string, Reached>): KnownObject[] {
    return this.figures
      .flatMap(({ name, parts }) => parts.filter(({ object }) => !now[name]?.there.includes(object)))
      .flatMap(({ object, pose }) => {
        const one = all.find(({ facts }) => facts.name === object);
        return one ? [{ ...one, pose: Float64Array.from(pose), held: false }] : [];
      });
  }

  private announce(reached: Record<string, Reached>): void {
    const won = newlyWon(this.objects.goals, this.told, reached);
    this.told = reached;
    if (won.length) say(byId("goals-said"), gettext("Won: {goals}.", { goals: won.map(({ title }) => title).join("; ") }));
  }
}

function wonInWords(one: Reached | undefined): string {
  if (!one || one.wonMs === null) return gettext("not yet");
  return gettext("won at {time}", { time: timeOfDay(one.wonMs) });
}
