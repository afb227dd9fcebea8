/** Shows people who watch an arm where it goes: the end and the way of the motion that runs, until its command ends. */
import type { ArmView } from "../arm/view.ts";
import { jointsAt } from "../socket/joint_path.ts";
import type { PathPacket } from "../socket/packets.ts";

const POINTS = 24; // of the drawn way, beside its begin
const COMMANDS = 2 ** 32; // of a path's command

/** The parts of the page that it needs: the command that runs for people who watch, and the newest joints (rad, m). */
interface WatchedPage {
  readonly target: { id: number } | null;
  readonly state: { joints: number[] } | null;
}

export class WatchedGoal {
  private begun: PathPacket | null = null;
  private shown: PathPacket | null = null;

  private page: () => WatchedPage;

  constructor(page: () => WatchedPage) {
    this.page = page;
  }

  /** Take the path of the motion that begins. */
  begin(path: PathPacket): void {
    this.begun = path;
  }

  /** Show it if its command still runs; called again and again. */
  draw(view: Pick<ArmView, "goesTo" | "toolAt"> | null): void {
    const { begun } = this,
      page = this.page(),
      path = begun && page.target && page.target.id % COMMANDS === begun.command ? begun : null;
    if (!view || path === this.shown) return;
    this.shown = path;
    if (!path) return view.goesTo(null);
    const at = (share: number): number[] => jointsAt(path, share * path.seconds);
    const way = Array.from({ length: POINTS + 1 }, (_, i) => view.toolAt(at(i / POINTS)) ?? []);
    const end = at(1);
    view.goesTo([...end, ...(page.state?.joints.slice(end.length) ?? [])], way);
  }
}
