/** The objects in the scene: drawn, listed with how and when their places were known, and what the ghost snaps to. */
import { byId, sayLines } from "../kit/dom.ts";
import { gettext, translate } from "../kit/text.ts";
import type { Pose } from "../motion/chain.ts";
import type { StreamPacket } from "../socket/packets.ts";
import { GoalPanel } from "./goal_panel.ts";
import { type KnownObject, seenInWords } from "./known.ts";
import { isSaidAt, missingInWords, type SceneObjects, snappedStep } from "./objects.ts";
import type { SceneView } from "./view.ts";

const OLD_MS = 600_000; // a place that was last known longer ago is drawn pale
const AGAIN_MS = 10_000;

export class Surroundings {
  private view: SceneView | null = null;
  private drawnAt = -Infinity;
  private list = byId("objects-list");
  private goals: GoalPanel;

  /** `now`: the server's time (ms). */
  constructor(
    private objects: SceneObjects,
    private now: () => number,
  ) {
    byId("scene-objects").hidden = false;
    this.goals = new GoalPanel(objects);
  }

  attach(view: SceneView): void {
    this.view = this.goals.view = view;
    if (this.objects.plate) view.plate(this.objects.plate);
    this.draw();
  }

  /** Take over a packet of one of the robot's streams. */
  take(name: string, packet: StreamPacket): void {
    if (this.objects.take(name, packet)) this.draw();
  }

  /** Show how old the places are; called often. */
  age(): void {
    if (performance.now() - this.drawnAt > AGAIN_MS) this.draw();
  }

  /** Return the pose to which the ghost's snaps, or its own. */
  snap(pose: Float64Array, from: Pose | null): Float64Array {
    return snappedStep(pose, this.objects.goal(pose), from);
  }

  /** Return the pose of the grasp or place at which words say that the ghost is, or its own. */
  exactPose(pose: Float64Array): Float64Array {
    const goal = this.objects.goal(pose);
    return goal && isSaidAt(pose, goal) ? goal.pose : pose;
  }

  /** Return what is missing to the nearest grasp or place, in words; empty if there is none. */
  words(pose: Pose): string {
    const goal = this.objects.goal(pose);
    return goal ? missingInWords(pose, goal) : "";
  }

  /** Show where the objects are, and how far the goals. */
  draw(): void {
    this.drawnAt = performance.now();
    const all = this.objects.all,
      now = this.now();
    this.view?.objects(
      all,
      (one) => now - one.atMs > OLD_MS,
      (one) => seenInWords(one, now),
    );
    const words = all.map((one) => `${translate(one.facts.name)}: ${whereabouts(one, now)}`);
    words.push(
      ...this.objects.lost.map(({ name, how }) =>
        gettext("{name}: {how}; where it is now is not known", { name: translate(name), how: translate(how) }),
      ),
    );
    sayLines(this.list, words);
    this.goals.draw();
  }
}

function whereabouts(one: KnownObject, now: number): string {
  if (one.planned) return one.held ? gettext("in the ghost's gripper, as recorded") : gettext("where the recorded task puts it");
  return one.held ? gettext("in the gripper") : how(one, now);
}

function how({ how: known, atMs }: KnownObject, now: number): string {
  const minutes = Math.floor(Math.max(0, now - atMs) / 60_000);
  const when = Number.isNaN(minutes)
    ? ""
    : minutes < 1
      ? gettext("just now")
      : minutes < 120
        ? gettext("{minutes} min ago", { minutes })
        : gettext("{hours} h ago", { hours: Math.floor(minutes / 60) });
  return [translate(known), when].filter(Boolean).join(", ") || gettext("told by the robot");
}
