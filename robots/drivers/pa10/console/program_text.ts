/** Programs as text and as a tree of steps: the text is stored, sent and run. */

export type Step =
  | { do: "joints"; values: number[]; speed?: number }
  | { do: "pose"; straight: boolean; values: number[]; speed?: number }
  | { do: "grip"; closed: boolean }
  | { do: "wait"; seconds: number }
  | { do: "repeat"; times: number; steps: Step[] }
  | { do: "line"; text: string };

const KNOWN = "j k l K W g d R E";
const NUMERAL = /^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?$/; // the arm's own: no 0x10, no Infinity

/** A number as the arm reads it; NaN if the arm would refuse it. */
export function numeral(word: string): number {
  return NUMERAL.test(word) ? Number(word) : NaN;
}

/** Return the steps in a text. Throws a sentence that names the line. */
export function parse(text: string): Step[] {
  const stack: Step[][] = [[]];
  for (const [i, raw] of text.split("\n").entries()) {
    const line = (raw.split("#")[0] ?? "").trim();
    if (!line) continue;
    const fail = (why: string): never => {
      throw new Error(`Line ${i + 1}: ${why}`);
    };
    const [letter = "", ...parts] = line.split(/\s+/);
    const numbers = parts.map(numeral);
    const bad = numbers.findIndex((n) => !Number.isFinite(n));
    if (!KNOWN.split(" ").includes(letter)) fail(`there is no step that begins with “${letter}”; known: ${KNOWN}.`);
    if (bad >= 0) fail(`“${parts[bad]}” is not a number.`);
    const want = (least: number, most = least): void => {
      if (numbers.length < least || numbers.length > most)
        fail(`${letter} needs ${least === most ? least : `${least} or ${most}`} numbers, not ${numbers.length}.`);
    };
    const here = stack[stack.length - 1]!;
    const speed = numbers.length > 6 ? { speed: numbers[6]! } : {};
    if (letter === "j") {
      want(6, 7);
      here.push({ do: "joints", values: numbers.slice(0, 6), ...speed });
    } else if (letter === "k" || letter === "l") {
      want(6, 7);
      here.push({ do: "pose", straight: letter === "l", values: numbers.slice(0, 6), ...speed });
    } else if (letter === "K") {
      want(6, 7);
      here.push({ do: "line", text: line });
    } else if (letter === "W") {
      want(0);
      here.push({ do: "line", text: line });
    } else if (letter === "g") {
      want(1);
      here.push({ do: "grip", closed: numbers[0] === 1 });
    } else if (letter === "d") {
      want(1);
      here.push({ do: "wait", seconds: numbers[0]! });
    } else if (letter === "R") {
      want(1);
      if (!Number.isInteger(numbers[0]) || numbers[0]! < 1 || numbers[0]! > 100) fail("a repetition is made 1 to 100 times.");
      const steps: Step[] = [];
      here.push({ do: "repeat", times: numbers[0]!, steps });
      stack.push(steps);
    } else {
      want(0);
      if (stack.length === 1) fail("E ends a repetition (R); there is none.");
      stack.pop();
    }
  }
  if (stack.length > 1) throw new Error("A repetition (R) has no end (E).");
  return stack[0]!;
}

/** Return the text of the steps, one line each. */
export function print(steps: readonly Step[]): string {
  return steps.map(lines).join("\n");
}

function lines(step: Step): string {
  const row = (letter: string, values: number[], speed?: number): string =>
    [letter, ...values.map(tidy), ...(speed === undefined ? [] : [tidy(speed)])].join(" ");
  switch (step.do) {
    case "joints": return row("j", step.values, step.speed);
    case "pose": return row(step.straight ? "l" : "k", step.values, step.speed);
    case "grip": return `g ${step.closed ? 1 : 0}`;
    case "wait": return `d ${tidy(step.seconds)}`;
    case "repeat": return [`R ${step.times}`, ...(step.steps.length ? [print(step.steps)] : []), "E"].join("\n");
    case "line": return step.text;
  }
}

function tidy(value: number): string {
  return String(Math.round(value * 1000) / 1000);
}
