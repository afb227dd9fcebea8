/** Programs as text and as a tree of steps: the text is stored, sent and run. */
import { gettext } from "/static/farhand/v1/text.js";

export type Step =
  | { do: "joints"; values: number[]; speed?: number }
  | { do: "pose"; straight: boolean; values: number[]; speed?: number }
  | { do: "grip"; closed: boolean }
  | { do: "wait"; seconds: number }
  | { do: "repeat"; times: number; steps: Step[] }
  | { do: "line"; text: string };

/** The least and the greatest of each value after a letter, and how many are required; see FORMS in forms.py. */
interface Form {
  values: readonly Bounds[];
  least: number;
}
interface Bounds {
  low: number;
  high: number;
  whole?: boolean;
}
const six = (first: number, last: number): Bounds[] => [first, first, first, last, last, last].map((most) => ({ low: -most, high: most }));
const SPEED: Bounds = { low: 0.05, high: 1 };
const PLACE: Form = { values: [...six(2000, 720), SPEED], least: 6 },
  NONE: Form = { values: [], least: 0 };
const one = (values: Bounds): Form => ({ values: [values], least: 1 });
const FORMS: Readonly<Record<string, Form>> = {
  j: { values: [...six(720, 720), SPEED], least: 6 },
  k: PLACE,
  l: PLACE,
  K: PLACE,
  W: NONE,
  g: one({ low: 0, high: 1, whole: true }),
  d: one({ low: 0, high: 30 }),
  R: one({ low: 1, high: 100, whole: true }),
  E: NONE,
};
const LONGEST_TEXT = 20_000,
  LONGEST_LINE = 200,
  LONGEST = 500,
  DEEPEST = 8; // characters (code points); steps, and lines that say something
const NUMERAL = /^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?$/; // the arm's own: no 0x10, no Infinity

/** Return a number as the arm reads it; NaN if the arm would refuse it. */
export function numeral(word: string): number {
  return NUMERAL.test(word) ? Number(word) : NaN;
}

/** Return the words of a line. Throws a sentence if the line is longer than the arm allows, or not plain ASCII. */
export function words(line: string): string[] {
  const said = line.replace(/^[ \t\r]+|[ \t\r]+$/g, "");
  if (said.length > LONGEST_LINE) throw new Error(gettext("the line is longer than {count} characters.", { count: LONGEST_LINE }));
  if (!/^[\t -~]*$/.test(said)) throw new Error(gettext("the line must be plain ASCII text."));
  return said ? said.split(/[ \t]+/) : [];
}

/** Return that a step or a line has the wrong count of numbers. */
export function wrongCount(letter: string, least: number, most: number, count: number): string {
  return least === most
    ? gettext("{letter} needs {least} numbers, not {count}.", { letter, least, count })
    : gettext("{letter} needs {least} or {most} numbers, not {count}.", { letter, least, most, count });
}

/** A repetition, or the program itself, that is being read; `size`: its steps with inner repetitions written out. */
interface Open {
  steps: Step[];
  times: number;
  size: number;
}

/** Return the steps in a text. Throws a sentence that names the line. */
export function parse(text: string): Step[] {
  if ([...text].length > LONGEST_TEXT) throw new Error(gettext("The program is longer than {count} characters.", { count: LONGEST_TEXT }));
  const stack: Open[] = [{ steps: [], times: 1, size: 0 }];
  let count = 0;
  for (const [i, raw] of text.split("\n").entries()) {
    try {
      const said = words(raw.split("#")[0] ?? "");
      if (!said.length) continue;
      if (++count > LONGEST) throw new Error(gettext("the program is longer than {count} lines.", { count: LONGEST }));
      read(said, stack);
      if (stack.reduce((sum, { size }) => sum + size, 0) > LONGEST)
        throw new Error(gettext("the program is longer than {count} steps.", { count: LONGEST }));
    } catch (error) {
      throw new Error(gettext("Line {number}: {error}", { number: i + 1, error: (error as Error).message }));
    }
  }
  if (stack.length > 1) throw new Error(gettext("A repetition (R) has no end (E)."));
  return stack[0]!.steps;
}

/** Take the words of one line into the innermost repetition. */
function read([letter = "", ...parts]: readonly string[], stack: Open[]): void {
  const form = Object.hasOwn(FORMS, letter) ? FORMS[letter] : undefined;
  if (!form)
    throw new Error(
      gettext("there is no step that begins with “{letter}”; known: {letters}.", { letter, letters: Object.keys(FORMS).join(" ") }),
    );
  const { least, values } = form,
    most = values.length,
    numbers = parts.map(numeral);
  const bad = numbers.findIndex((n) => !Number.isFinite(n));
  if (bad >= 0) throw new Error(gettext("“{text}” is not a number.", { text: parts[bad] ?? "" }));
  if (numbers.length < least || numbers.length > most) throw new Error(wrongCount(letter, least, most, numbers.length));
  for (const [n, { low, high, whole }] of values.slice(0, numbers.length).entries())
    if (numbers[n]! < low || numbers[n]! > high || (whole && !Number.isInteger(numbers[n])))
      throw new Error(
        whole
          ? gettext("number {number} of {letter} must be a whole number from {low} to {high}.", { number: n + 1, letter, low, high })
          : gettext("number {number} of {letter} must be from {low} to {high}.", { number: n + 1, letter, low, high }),
      );
  const here = stack.at(-1)!,
    speed = numbers.length > 6 ? { speed: numbers[6]! } : {};
  const add = (step: Step): void => void (here.steps.push(step), (here.size += 1));
  switch (letter) {
    case "j":
      return add({ do: "joints", values: numbers.slice(0, 6), ...speed });
    case "k":
    case "l":
      return add({ do: "pose", straight: letter === "l", values: numbers.slice(0, 6), ...speed });
    case "g":
      return add({ do: "grip", closed: numbers[0] === 1 });
    case "d":
      return add({ do: "wait", seconds: numbers[0]! });
    case "R": {
      if (stack.length > DEEPEST) throw new Error(gettext("repetitions stand at most {count} deep in each other.", { count: DEEPEST }));
      const steps: Step[] = [];
      here.steps.push({ do: "repeat", times: numbers[0]!, steps });
      return void stack.push({ steps, times: numbers[0]!, size: 0 });
    }
    case "E": {
      if (stack.length === 1) throw new Error(gettext("E ends a repetition (R); there is none."));
      stack.pop();
      return void (stack.at(-1)!.size += here.times * here.size);
    }
    default:
      return add({ do: "line", text: [letter, ...parts].join(" ") });
  }
}

/** Return the text of the steps, one line each. */
export function print(steps: readonly Step[]): string {
  return steps.map(lines).join("\n");
}

function lines(step: Step): string {
  const row = (letter: string, values: number[], speed?: number): string =>
    [letter, ...values.map(tidy), ...(speed === undefined ? [] : [tidy(speed)])].join(" ");
  switch (step.do) {
    case "joints":
      return row("j", step.values, step.speed);
    case "pose":
      return row(step.straight ? "l" : "k", step.values, step.speed);
    case "grip":
      return `g ${step.closed ? 1 : 0}`;
    case "wait":
      return `d ${tidy(step.seconds)}`;
    case "repeat":
      return [`R ${step.times}`, ...(step.steps.length ? [print(step.steps)] : []), "E"].join("\n");
    case "line":
      return step.text;
  }
}

function tidy(value: number): string {
  return String(Math.round(value * 1000) / 1000);
}
