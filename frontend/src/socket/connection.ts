/** Where a page's messages and packets come from: the socket to the robot, or a recording of it. */
import { RobotSocket } from "./robot_socket.ts";

/** The parts of a connection that a page uses. */
export interface Connection {
  readonly up: boolean;
  readonly lost: boolean;
  readonly lostMs: number;
  readonly opened: number;
  readonly latency: number | null;
  readonly best: number;
  readonly overdue: boolean;
  /** How much later than over the empty line what is sent now arrives, ms; a recording sends nothing. */
  readonly lateMs?: number;
  /** Server time, or the time of the recording, ms. */
  now(): number;
  heardSince(at: number): boolean;
  check(): void;
  send(message: object): boolean;
  /** Open the operator's stream; a recording has none. */
  operate?(): void;
}
type OpenConnection = (...all: ConstructorParameters<typeof RobotSocket>) => Connection;

let recording: OpenConnection | null = null;

/** Make pages show a recording; called before the robot's console begins. */
export function useRecording(open: OpenConnection): void {
  recording = open;
}

export function isReplay(): boolean {
  return recording !== null;
}

export const openConnection: OpenConnection = (...all) => (recording ? recording(...all) : new RobotSocket(...all));
