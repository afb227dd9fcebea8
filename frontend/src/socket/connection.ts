/** Where a page's messages and packets come from: the socket to the robot, or a recording of it. */
import type { CompactLayout } from "./compact_state.ts";
import { type Handlers, Live } from "./robot_socket.ts";

/** What a page uses of its line. */
export interface Line {
  readonly up: boolean; readonly lost: boolean; readonly lostMs: number; readonly opened: number;
  readonly latency: number | null; readonly best: number; readonly overdue: boolean;
  /** Server time, or the time of the recording, ms. */
  now(): number;
  heardSince(at: number): boolean;
  check(): void;
  send(message: object): boolean;
  /** Have the operator's own stream; only a socket has one. */
  operate?(): void;
}
export type Open = (
  slug: string, handlers: Handlers, pingEvery: () => number, layout: CompactLayout | null, wish: (moved: boolean) => object,
) => Line;

let recording: Open | null = null;

/** Have pages show a recording; called before the robot's console begins. */
export function replayWith(open: Open): void {
  recording = open;
}

export function replaying(): boolean {
  return recording !== null;
}

export const openLine: Open = (slug, handlers, pingEvery, layout, wish) =>
  recording ? recording(slug, handlers, pingEvery, layout, wish) : new Live(slug, handlers, pingEvery, layout, wish);
