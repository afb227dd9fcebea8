/** The hall in 3D in the place of the map. It is loaded while the page is idle, so that it works without a connection. */
import { byId, prefetch, type RobotPage, say } from "/static/farhand/v1/console.js";
import type { FloorView } from "/static/farhand/v1/floor_view.js";
import type { Description } from "./hall_map.ts";
import { gettext, translate } from "/static/farhand/v1/text.js";

type Pose = readonly [number, number, number];
const parts = (): Promise<typeof import("/static/farhand/v1/floor_view.js")> => import("/static/farhand/v1/floor_view.js");

export class HallInDepth {
  private view: FloorView | null = null;
  private at: Pose | null = null;
  private planned: [readonly Pose[] | null, boolean] = [null, true];
  private goal: readonly [number, number] | null = null;

  constructor(
    private page: RobotPage,
    private box: HTMLElement,
    private button: HTMLButtonElement,
    private d: Description,
    private onPick: (x: number, y: number) => void,
  ) {
    prefetch(page, parts);
    button.addEventListener("click", () => void this.turn(button.getAttribute("aria-pressed") !== "true"));
  }

  private async turn(deep: boolean): Promise<void> {
    this.face(deep);
    if (!deep || this.view) return;
    const loaded = await parts().catch(() => null);
    if (loaded) this.open(loaded.FloorView);
    else {
      this.face(false);
      this.page.notice(gettext("The 3D view did not come. Reload the page when the connection is back; the map works."), "warning");
    }
  }

  /** Show the 3D view or the map. */
  private face(deep: boolean): void {
    this.button.setAttribute("aria-pressed", String(deep));
    say(this.button, deep ? gettext("Show it from above") : gettext("Show it in 3D"));
    this.box.hidden = !deep;
    byId("hall").toggleAttribute("hidden", deep);
  }

  private open(View: typeof FloorView): void {
    if (this.view) return; // it was pressed again meanwhile
    try {
      const { hall, body } = this.d,
        { width, depth } = hall;
      const cases = hall.case.map(({ black, ...one }) => ({ ...one, dark: black === true }));
      const standing = [...cases, ...hall.exhibit].map((one) => ({ ...one, name: translate(one.name) }));
      const marks = hall.node.map(({ name, at }) => ({ name: translate(name), at }));
      const floor = { width, depth, standing, marks };
      this.view = new View(this.box, floor, [body.length, body.width, body.height], this.onPick);
      this.view.show(this.at);
      this.view.plan(...this.planned);
      this.view.mark(this.goal);
    } catch (error) {
      console.warn(error);
      this.button.hidden = true; // this browser draws nothing in 3D
      this.face(false);
    }
  }

  show(at: Pose | null): void {
    this.at = at;
    this.view?.show(at);
  }

  plan(corners: readonly Pose[] | null, good: boolean): void {
    this.planned = [corners, good];
    this.view?.plan(corners, good);
  }

  /** Mark the place (m) to which the rover drives; null for none. */
  mark(at: readonly [number, number] | null): void {
    this.goal = at;
    this.view?.mark(at);
  }

  ghost(at: Pose | null): void {
    this.view?.ghost(at);
  }
}
