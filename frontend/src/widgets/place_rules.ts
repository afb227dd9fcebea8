/** Which places of a turn are offered again. */

type Place = readonly number[];
const MOST = 5;
const SAME_M = 0.002; // two places this near to each other are one

/** Return the last places after one more, the newest first; each is there once. */
export function placesAfter(before: readonly Place[], place: Place): Place[] {
  const others = before.filter((one) => Math.hypot(...one.map((v, i) => v - place[i]!)) > SAME_M);
  return [place, ...others].slice(0, MOST);
}
