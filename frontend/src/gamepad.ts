/** The directions that a gamepad's sticks give. */

export type Direction = readonly [number, number];
const STICK = 0.5;

/** The direction of a gamepad's left stick or cross; null at rest. Up is away from the robot. */
export function stick(pad: Pick<Gamepad, "axes" | "buttons" | "connected"> | null): Direction | null {
  if (!pad?.connected) return null;
  const down = (i: number): number => (pad.buttons[i]?.pressed ? 1 : 0);
  const x = (pad.axes[0] ?? 0) + down(15) - down(14);
  const y = down(12) - down(13) - (pad.axes[1] ?? 0);
  return Math.hypot(x, y) < STICK ? null : [Math.max(-1, Math.min(1, x)), Math.max(-1, Math.min(1, y))];
}

/** How a gamepad's two sticks would move a tool; null at rest. Up on the left stick is away from the base. */
export function twist(pad: Pick<Gamepad, "axes" | "connected"> | null): Record<string, number> | null {
  if (!pad?.connected) return null;
  const pull = (i: number): number => {
    const v = pad.axes[i] ?? 0;
    return Math.abs(v) < STICK ? 0 : Math.max(-1, Math.min(1, -v));
  };
  const way = { x: pull(1), y: pull(0), z: pull(3), yaw: pull(2) };
  const felt = Object.entries(way).filter(([, v]) => v !== 0);
  return felt.length ? Object.fromEntries(felt) : null;
}
