/** How fast the ghost goes by what tells a speed. */
import type { Move } from "./source.ts";

export const M_PER_S = 0.12,
  RAD_PER_S = 0.6; // of a stick that is pushed all the way

/** Return how far that goes in a time; `push`: shares of full speed. */
export function pushed(push: Move, seconds: number): Move {
  const along = M_PER_S * seconds,
    about = RAD_PER_S * seconds;
  const [x, y, z, u, v, w] = push;
  return [x * along, y * along, z * along, u * about, v * about, w * about];
}
