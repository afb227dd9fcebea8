/** Tasks of an arm with objects, as text and as a tree of steps (robots/kit/arms/tasks/parsing.py): the text is what runs. */

export type TaskStep =
  | { do: "grasp"; name: string }
  | { do: "on"; name: string; on: string; by?: number[]; stud?: number[]; turned?: number }
  | { do: "at"; name: string; at: number[]; yaw?: number }
  | { do: "move"; place: number[]; angles?: number[] }
  | { do: "posture"; posture: string }
  | { do: "open" }
  | { do: "close" }
  | { do: "wait"; seconds: number }
  | { do: "lies"; name: string; on: string }
  | { do: "holds"; name: string | null }
  | { do: "repeat"; times: number; steps: TaskStep[] }
  | { do: "line"; text: string }; // of a block: whatever somebody typed into it

const LONGEST_TEXT = 6000,
  LONGEST_LINE = 120,
  MOST_LINES = 200,
  MOST_STEPS = 200,
  MOST_TIMES = 100,
  DEEPEST = 4,
  LONGEST_WAIT = 30,
  FARTHEST = 3000,
  MOST_DEGREES = 360,
  MOST_STUDS = 99;
export const PLATE = "plate"; // with studs, on which objects are put
const ALLOWED: Readonly<Record<string, string>> = {
  grasp: "grasp A",
  put: "put A on B [by DX DY] [turned DEG] | put A on plate at COLUMN ROW [turned DEG] | put A at X Y [YAW]",
  move: "move X Y Z [ROLL PITCH YAW] | move POSTURE",
  open: "open",
  close: "close",
  wait: "wait SECONDS",
  repeat: "repeat TIMES",
  end: "end",
  expect: "expect A on B | expect holding A | expect empty",
};
const NUMERAL = /^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?$/,
  NAME = /^[A-Za-z][A-Za-z0-9_-]{0,29}$/;

/** A repetition, or the task itself, that is being read. */
interface Open {
  times: number;
  line: number;
  steps: TaskStep[];
}

/** Return the steps of a text. Throws a sentence that names the line and what is allowed there. */
export function parseTask(text: string): TaskStep[] {
  if ([...text].length > LONGEST_TEXT) throw new Error(`A task has at most ${LONGEST_TEXT} characters.`);
  const lines = text.split("\n");
  if (lines.length > MOST_LINES) throw new Error(`A task has at most ${MOST_LINES} lines.`);
  const stack: Open[] = [{ times: 1, line: 0, steps: [] }];
  for (const [i, line] of lines.entries()) {
    const said = (line.split("#")[0] ?? "").replace(/^[ \t\r]+|[ \t\r]+$/g, "");
    if (!said) continue;
    try {
      if ([...line].length > LONGEST_LINE) throw new Error(`a line has at most ${LONGEST_LINE} characters`);
      take(stack, said.split(/[ \t\r]+/), i + 1);
    } catch (error) {
      throw new Error(`Line ${i + 1}: ${(error as Error).message}.`);
    }
  }
  if (stack.length > 1) throw new Error(`Line ${stack.at(-1)!.line}: this repeat has no end.`);
  const { steps } = stack[0]!;
  if (!steps.length) throw new Error("The task has no step.");
  const all = count(steps);
  if (all > MOST_STEPS) throw new Error(`The task has ${all} steps with its repetitions; at most ${MOST_STEPS} are possible.`);
  return steps;
}

function count(steps: readonly TaskStep[]): number {
  return steps.reduce((sum, step) => sum + (step.do === "repeat" ? step.times * count(step.steps) : 1), 0);
}

function take(stack: Open[], [word = "", ...rest]: readonly string[], line: number): void {
  const { steps } = stack.at(-1)!;
  if (word === "repeat") {
    if (stack.length > DEEPEST) throw new Error(`repetitions stand at most ${DEEPEST} deep in each other`);
    const [times = ""] = only(word, rest, 1);
    if (!/^[0-9]{1,3}$/.test(times) || Number(times) < 1 || Number(times) > MOST_TIMES)
      throw new Error(`repeat needs a whole number from 1 to ${MOST_TIMES}, not '${times.slice(0, 12)}'`);
    stack.push({ times: Number(times), line, steps: [] });
  } else if (word === "end") {
    only(word, rest, 0);
    if (stack.length === 1) throw new Error("end ends a repeat; there is none");
    if (!steps.length) throw new Error("nothing stands between repeat and end");
    const { times } = stack.pop()!;
    stack.at(-1)!.steps.push({ do: "repeat", times, steps });
  } else steps.push(step(word, rest));
}

function step(word: string, rest: readonly string[]): TaskStep {
  switch (word) {
    case "grasp":
      return { do: "grasp", name: named(only(word, rest, 1)[0]) };
    case "put":
      return put(rest);
    case "move": {
      if (only(word, rest, 1, 3, 6).length === 1) return { do: "posture", posture: named(rest[0]) };
      const place = rest.slice(0, 3).map((part) => real(part, FARTHEST)),
        angles = rest.slice(3).map((part) => real(part, MOST_DEGREES));
      return { do: "move", place, ...(angles.length ? { angles } : {}) };
    }
    case "open":
    case "close":
      only(word, rest, 0);
      return { do: word };
    case "wait":
      return { do: "wait", seconds: real(only(word, rest, 1)[0], LONGEST_WAIT, 0) };
    case "expect":
      if (rest.length === 1 && rest[0] === "empty") return { do: "holds", name: null };
      if (rest.length === 2 && rest[0] === "holding") return { do: "holds", name: named(rest[1]) };
      if (rest.length === 3 && rest[1] === "on") return { do: "lies", name: named(rest[0]), on: named(rest[2]) };
      throw new Error(`allowed: ${ALLOWED["expect"]}`);
    default:
      throw new Error(`'${[...word].slice(0, 12).join("")}' is no step; allowed: ${Object.keys(ALLOWED).join(", ")}`);
  }
}

function put(rest: readonly string[]): TaskStep {
  if ((rest.length === 4 || rest.length === 5) && rest[1] === "at") {
    const [x, y, yaw] = rest.slice(2).map((part, n) => real(part, n < 2 ? FARTHEST : MOST_DEGREES));
    return { do: "at", name: named(rest[0]), at: [x!, y!], ...(yaw === undefined ? {} : { yaw }) };
  }
  if (rest.length >= 3 && rest[1] === "on") {
    let more = rest.slice(3);
    const extra: { by?: number[]; stud?: number[]; turned?: number } = {};
    if (rest[2] === PLATE && more[0] === "at" && (more.length === 3 || more.length === 5)) {
      extra.stud = [stud(more[1]), stud(more[2])];
      more = more.slice(3);
    } else if (more[0] === "by" && (more.length === 3 || more.length === 5)) {
      extra.by = [real(more[1], FARTHEST), real(more[2], FARTHEST)];
      more = more.slice(3);
    }
    if (more[0] === "turned" && more.length === 2) {
      extra.turned = real(more[1], MOST_DEGREES);
      more = [];
    }
    if (!more.length) return { do: "on", name: named(rest[0]), on: named(rest[2]), ...extra };
  }
  throw new Error(`allowed: ${ALLOWED["put"]}`);
}

function only(word: string, rest: readonly string[], ...counts: number[]): readonly string[] {
  if (!counts.includes(rest.length)) throw new Error(`allowed: ${ALLOWED[word]}`);
  return rest;
}

function named(text = ""): string {
  if (!NAME.test(text)) throw new Error(`'${[...text].slice(0, 12).join("")}' is no name: letters, digits and hyphens, at most 30`);
  return text;
}

/** Return the number of a column or a row of studs. */
function stud(text = ""): number {
  const value = /^[0-9]{1,2}$/.test(text) ? Number(text) : 0;
  if (value < 1 || value > MOST_STUDS)
    throw new Error(`'${[...text].slice(0, 12).join("")}' must be a whole number from 1 to ${MOST_STUDS}, a column or row of studs`);
  return value;
}

/** Return a number, rounded to the three decimals that tasks have. */
function real(text = "", most: number, least = -most): number {
  const value = NUMERAL.test(text) ? Number(text) : NaN;
  if (!(value >= least && value <= most)) throw new Error(`'${[...text].slice(0, 12).join("")}' must be a number from ${least} to ${most}`);
  return Number(tidy(value));
}

/** Return the text of the steps, one line each. */
export function printTask(steps: readonly TaskStep[], indent = ""): string {
  return steps
    .map((one) =>
      one.do === "repeat" ? `${indent}repeat ${one.times}\n${printTask(one.steps, `${indent}  `)}\n${indent}end` : indent + line(one),
    )
    .join("\n");
}

function line(one: Exclude<TaskStep, { do: "repeat" }>): string {
  const row = (...parts: (string | number | undefined)[]): string =>
    parts
      .filter((part) => part !== undefined)
      .map((part) => (typeof part === "number" ? tidy(part) : part))
      .join(" ");
  switch (one.do) {
    case "grasp":
      return row("grasp", one.name);
    case "on":
      return row(
        "put",
        one.name,
        "on",
        one.on,
        ...(one.stud ? ["at", ...one.stud] : one.by ? ["by", ...one.by] : []),
        ...(one.turned === undefined ? [] : ["turned", one.turned]),
      );
    case "at":
      return row("put", one.name, "at", ...one.at, one.yaw);
    case "move":
      return row("move", ...one.place, ...(one.angles ?? []));
    case "posture":
      return row("move", one.posture);
    case "wait":
      return row("wait", one.seconds);
    case "lies":
      return row("expect", one.name, "on", one.on);
    case "holds":
      return one.name === null ? "expect empty" : row("expect holding", one.name);
    case "line":
      return one.text;
    default:
      return one.do;
  }
}

function tidy(value: number): string {
  const text = value.toFixed(3).replace(/\.?0+$/, "");
  return text === "-0" ? "0" : text;
}
