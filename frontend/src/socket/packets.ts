/** The contents of the socket's binary packets, and the layout of compact states. */
/** The layout of compact states in a spec: the first byte, the controller's words, the number of joints, the scales. */
export interface CompactLayout {
  mark: number;
  modes: string[];
  joints: number;
  scales: [low: number, step: number, bits: number, steps: number][];
}

export interface StatePacket {
  moving: boolean;
  stopped: boolean;
  number: number;
  atMs: number;
  /** rad and m; velocities and torques are empty if the robot does not send them. */
  joints: number[];
  velocities: number[];
  torques: number[];
  /** Values of the spec's channels, then the coordinates of its pose, in the spec's order; NaN if not known. */
  values: number[];
  /** The body's velocity along and about its own axes (m/s, rad/s), a number for each coordinate of the pose; empty if not known. */
  twist?: number[];
  /** The controller's own word for what it is doing. */
  mode: string;
}
/**
 * A picture of a camera. With video `image` holds it, valid only during the call, `jpeg` is empty, and joints and twist
 * are missing. `pose`, `twist`: the robot's pose and velocity (m, rad; m/s, rad/s); empty if not known. `first`: forget
 * earlier pictures, because a replay has jumped in time.
 */
export interface PicturePacket {
  camera: number;
  number: number;
  atMs: number;
  still: number;
  joints: number[];
  pose?: number[];
  twist?: number[];
  jpeg: Blob;
  image?: VideoFrame;
  first?: boolean;
}

/** How live video is coded. */
export type Coding = "vp8" | "vp9";

/** A packet of a camera's video. `follows`: the number of the picture that it changes; null for a key picture. */
export interface VideoPacket {
  camera: number;
  number: number;
  atMs: number;
  still: number;
  follows: number | null;
  run: number;
  coded: Uint8Array<ArrayBuffer>;
}

/** A packet of a byte stream. `stream`: its number in the spec, from 0; `key`: it contains everything, not only changes. */
export interface StreamPacket {
  stream: number;
  key: boolean;
  run: number;
  number: number;
  atMs: number;
  data: Uint8Array;
}

/** A packet of sound, `ms` long; `number` counts the microphone's time. One with 0 ms only says why nothing is heard. */
export interface SoundPacket {
  run: number;
  number: number;
  atMs: number;
  ms: number;
  opus: Uint8Array<ArrayBuffer>;
  said: string;
}
/**
 * A motion of the robot's first joints: positions (rad, m) at equal times, the first at `beganMs` (server ms), the last
 * `seconds` later, where it rests. `velocity` (rad/s, m/s): at the beginning; empty: at rest. Nothing of it is measured.
 */
export interface JointMotion {
  beganMs: number;
  seconds: number;
  knots: number[][];
  velocity: number[];
}
/** The motion that the robot intends by a command that it has begun; `command`: the low 32 bits of its number. */
export interface PathPacket extends JointMotion {
  command: number;
}
export type Packet = PathPacket | StatePacket | PicturePacket | StreamPacket | VideoPacket | SoundPacket;
