/** Where a page's messages and packets come from: the socket to the robot, or a recording of it. */
import type { CompactLayout } from "./compact_state.ts";
import { type Handlers, RobotSocket } from "./robot_socket.ts";

/** What a page uses of its line. */
export interface Connection {
  readonly up: boolean;
  readonly lost: boolean;
  readonly lostMs: number;
  readonly opened: number;
  readonly latency: number | null;
  readonly best: number;
  readonly overdue: boolean;
  /** Server time, or the time of the recording, ms. */
  now(): number;
  heardSince(at: number): boolean;
  check(): void;
  send(message: object): boolean;
  /** Have the operator's own stream; only a socket has one. */
  operate?(): void;
}
export type OpenConnection = (
  slug: string,
  handlers: Handlers,
  pingEvery: () => number,
  layout: CompactLayout | null,
  wish: (moved: boolean) => object,
) => Connection;

let recording: OpenConnection | null = null;

/** Have pages show a recording; called before the robot's console begins. */
export function useRecording(open: OpenConnection): void {
  recording = open;
}

export function isReplay(): boolean {
  return recording !== null;
}

export const openConnection: OpenConnection = (slug, handlers, pingEvery, layout, wish) =>
  recording ? recording(slug, handlers, pingEvery, layout, wish) : new RobotSocket(slug, handlers, pingEvery, layout, wish);
