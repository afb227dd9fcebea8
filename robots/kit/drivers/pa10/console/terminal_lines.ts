/** The arm's own lines as commands of the portal. */
import type { Target } from "/static/farhand/v1/arm.js";
import { numeral, words, wrongCount } from "./program_text.ts";
import { gettext } from "/static/farhand/v1/text.js";

const PLACE = ["x", "y", "z", "roll", "pitch", "yaw"];

/** Return the command that a line stands for. Throws a sentence if there is none. */
export function understood(line: string, axes: string[]): Target {
  const [letter = "", ...parts] = words(line);
  const numbers = parts.map(numeral);
  const bad = numbers.findIndex((n) => !Number.isFinite(n));
  if (bad >= 0) throw new Error(gettext("{text} is not a number.", { text: parts[bad] ?? "" }));
  const count = (least: number, most: number): void => {
    if (numbers.length < least || numbers.length > most) throw new Error(wrongCount(letter, least, most, numbers.length));
  };
  const speed: Record<string, number> = numbers.length > 6 ? { speed: numbers[6] ?? 0 } : {};
  if (letter === "j") {
    count(6, 7);
    return { kind: "joints", args: { ...Object.fromEntries(axes.map((name, i) => [name, rad(numbers[i] ?? 0)])), ...speed } };
  }
  if (letter === "k" || letter === "l") {
    count(6, 7);
    const args = Object.fromEntries(PLACE.map((name, i) => [name, i < 3 ? (numbers[i] ?? 0) / 1000 : rad(numbers[i] ?? 0)]));
    return { kind: letter === "k" ? "pose" : "line", args: { ...args, ...speed } };
  }
  if (letter === "g") {
    count(1, 1);
    return { kind: "gripper", args: { closed: numbers[0] ?? 0 } };
  }
  if (letter === "p") {
    count(1, 1);
    return { kind: "program", args: { number: numbers[0] ?? 0 } };
  }
  throw new Error(gettext("There is no command that begins with “{letter}”; known: j k l g p h w.", { letter }));
}

function rad(degrees: number): number {
  return (degrees * Math.PI) / 180;
}
