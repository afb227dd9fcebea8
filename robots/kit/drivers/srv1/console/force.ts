/** The force that pushes the stick back, by what the rover's sensors read ahead, and how a person feels it. */

export interface Ranges {
  infrared: { stop: number; far: number };
  sonar: { stop: number };
}
/** An effect of a gamepad's motors, as `playEffect` takes it. */
interface Rumble {
  duration: number;
  strongMagnitude: number;
  weakMagnitude: number;
}

const SONAR_FAR_M = 1.5,
  SONAR_NEAR_M = 0.3; // between them its force grows
const SONAR_MOST = 0.6; // the most force by sonar alone, because it may look past what infrared sees
const LEAST = 0.05; // less is not felt
export const EVERY_MS = 200; // between two effects; each lasts until the next

/** Return the force, from 0 (nothing near) to 1 (the reflex). `ahead`: how far the stick is pushed ahead; 0 for driving back. */
export function force(
  infrared: number | undefined,
  sonar: number | undefined,
  ahead: number,
  { infrared: { stop, far }, sonar: reflex }: Ranges,
): number {
  if (!(ahead > 0)) return 0;
  const near = (value: number | undefined, from: number, to: number): number =>
    value === undefined || !Number.isFinite(value) || !(from > to) ? 0 : Math.max(0, Math.min(1, (from - value) / (from - to))) ** 2;
  return Math.max(near(infrared, far, Math.max(stop, reflex.stop)), SONAR_MOST * near(sonar, SONAR_FAR_M, SONAR_NEAR_M));
}

/** Return the effect of a gamepad for a force; null for none. */
export function rumble(level: number): Rumble | null {
  return level > LEAST ? { duration: EVERY_MS, strongMagnitude: Math.min(1, level), weakMagnitude: Math.min(1, 0.3 + 0.7 * level) } : null;
}

/** Return how long (ms) a phone vibrates until the next effect; 0 for not at all. */
export function buzz(level: number): number {
  return level > LEAST ? Math.round(15 + 0.6 * EVERY_MS * Math.min(1, level)) : 0;
}
