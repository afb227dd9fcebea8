/** Missions as text, as the rover reads it (missions.py); the text is stored, sent and run. */
import type { Node } from "./hall_map.ts";

export type Step =
  | { do: "go"; x: number; y: number; name: string }
  | { do: "turn"; degrees: number }
  | { do: "wait" | "patrol"; seconds: number }
  | { do: "look" | "photograph" | "read" }
  | { do: "say"; words: string };
/** The places of the map that a mission may name, and the size of the hall (m). */
export interface Floor {
  width: number;
  depth: number;
  node: readonly Node[];
}

export const LONGEST = 4000,
  MOST_STEPS = 60;
const LONGEST_LINE = 160;
const RANGES: Record<"turn" | "wait" | "patrol", readonly [number, number, string, string]> = {
  turn: [-360, 360, "an angle", "°"],
  wait: [0, 120, "a time", "s"],
  patrol: [1, 120, "a time", "s"],
};
/** No text has these; see UNWRITABLE in missions.py. */
const UNWRITABLE = /[\0-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]|\r(?!$)/u;
const NUMERAL = /^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?$/;

/** Return the steps in a text. Lengths are of code points. Throws a sentence that names the line. */
export function parse(text: string, floor: Floor): Step[] {
  if (count(text) > LONGEST) throw new Error(`A mission has at most ${LONGEST} characters.`);
  const found: Step[] = [];
  for (const [i, raw] of text.split("\n").entries()) {
    const odd = UNWRITABLE.exec(raw)?.[0].codePointAt(0);
    if (odd !== undefined)
      throw new Error(`Line ${i + 1}: a mission cannot have the character U+${odd.toString(16).toUpperCase().padStart(4, "0")}.`);
    const line = raw.trim();
    if (!line || line.startsWith("#")) continue;
    try {
      found.push(step(line, floor));
    } catch (error) {
      throw new Error(`Line ${i + 1}: ${(error as Error).message}.`);
    }
    if (found.length > MOST_STEPS) throw new Error(`A mission has at most ${MOST_STEPS} steps.`);
  }
  if (!found.length) throw new Error("A mission has at least one step.");
  return found;
}

function step(line: string, floor: Floor): Step {
  if (count(line) > LONGEST_LINE) throw new Error(`a step has at most ${LONGEST_LINE} characters`);
  const at = line.indexOf(" ");
  const verb = at < 0 ? line : line.slice(0, at),
    rest = at < 0 ? "" : line.slice(at).trim();
  if (verb === "go") return go(rest, floor);
  if (verb === "say") {
    if (!rest) throw new Error("say what? Write the words after it");
    return { do: "say", words: rest };
  }
  if (verb === "turn") return { do: "turn", degrees: within(rest, ...RANGES.turn) };
  if (verb === "wait" || verb === "patrol") return { do: verb, seconds: within(rest, ...RANGES[verb]) };
  if (verb === "look" && rest === "around") return { do: "look" };
  if ((verb === "photograph" || verb === "read") && !rest) return { do: verb };
  throw new Error(`there is no step “${begin(line, 40)}”; steps are go, turn, look around, photograph, read, wait, patrol and say`);
}

function go(rest: string, floor: Floor): Step {
  const node = floor.node.find(({ name }) => name.toLowerCase() === rest.toLowerCase());
  if (node) return { do: "go", x: node.at[0], y: node.at[1], name: node.name };
  const [x, y, ...more] = rest.split(/\s+/);
  if (!x || !y || more.length || !/[0-9]/.test(rest))
    throw new Error(`go where? Write two numbers in m, or one of ${floor.node.map(({ name }) => name).join(", ")}`);
  return {
    do: "go",
    name: "",
    x: within(x, 0, floor.width, "the distance from the left wall", "m"),
    y: within(y, 0, floor.depth, "the distance from the lower wall", "m"),
  };
}

function within(text: string, low: number, high: number, what: string, unit: string): number {
  const value = NUMERAL.test(text) ? Number(text) : NaN;
  if (!(value >= low && value <= high))
    throw new Error(`${what} lies between ${low} and ${high} ${unit}, not ${text ? `“${begin(text, 20)}”` : "nothing"}`);
  return rounded(value);
}

function count(text: string): number {
  return [...text].length;
}

function begin(text: string, most: number): string {
  return [...text].slice(0, most).join("");
}

/** A number to thousandths, halves up, as in Python. */
function rounded(value: number): number {
  return Math.floor(1000 * value + 0.5) / 1000;
}

/** Return the text of the steps, one line each. */
export function print(steps: readonly Step[]): string {
  return steps.map(lineOf).join("\n");
}

export function lineOf(step: Step): string {
  switch (step.do) {
    case "go":
      return step.name ? `go ${step.name}` : `go ${rounded(step.x)} ${rounded(step.y)}`;
    case "turn":
      return `turn ${rounded(step.degrees)}`;
    case "wait":
    case "patrol":
      return `${step.do} ${rounded(step.seconds)}`;
    case "look":
      return "look around";
    case "say":
      return `say ${step.words}`;
    default:
      return step.do;
  }
}
