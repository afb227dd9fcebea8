/** The text of a rule set, as the rover reads it (robots/kit/rovers/fuzzy_text.py); the text is what is sent. */
import type { Method, RuleSet, Variable } from "./fuzzy.ts";

const TERMS = 5,
  LONGEST = 2048,
  LINES = 64;
const LABEL = "[A-Za-z](?:[A-Za-z -]{0,10}[A-Za-z])?";
const TERM = new RegExp(`^(${LABEL}) (-?[0-9]{1,4}(?:\\.[0-9]{1,3})?)$`);
const VARIABLE = /^(input|output) ([a-z]{1,16}) ([A-Za-z/%]{1,4}): (.*)$/s;
const RULE = new RegExp(`^rule (${LABEL}), (${LABEL}): (${LABEL})$`);

/** Return the rule set of a text; pairs without a rule have -1. Throws a sentence for a person. */
export function parse(text: string): RuleSet {
  if (text.length > LONGEST || text.split("\n").length > LINES || !/^[ -~\n]*$/.test(text))
    throw new Error(`A rule set has at most ${LONGEST} characters, all printable ASCII, in ${LINES} lines.`);
  const methods: Method[] = [],
    inputs: Variable[] = [],
    outputs: Variable[] = [],
    rules: RegExpExecArray[] = [];
  for (const line of text.split("\n")) {
    const rule = RULE.exec(line),
      one = VARIABLE.exec(line);
    if (rule) rules.push(rule);
    else if (one) (one[1] === "input" ? inputs : outputs).push(variable(one[2]!, one[3]!, one[4]!));
    else if (line === "method sugeno" || line === "method mamdani") methods.push(line.slice(7) as Method);
    else if (line && !line.startsWith("#")) throw new Error(`This is no line of a rule set: “${line.slice(0, 60)}”.`);
  }
  const [first, second] = inputs,
    output = outputs[0];
  if (methods.length !== 1 || inputs.length !== 2 || outputs.length !== 1 || !first || !second || !output)
    throw new Error("A rule set has one method, two inputs and one output.");
  return { method: methods[0]!, inputs: [first, second], output, table: table(rules, [first, second], output) };
}

function variable(name: string, unit: string, terms: string): Variable {
  const parts = terms.split(", ").map((term) => TERM.exec(term));
  if (!parts.every((part) => part !== null))
    throw new Error(`The terms of the ${name} must be a label of at most 12 letters, spaces and hyphens and a number each.`);
  const labels = parts.map((part) => part[1]!);
  if (labels.length !== TERMS || new Set(labels).size !== TERMS) throw new Error(`The ${name} needs ${TERMS} different terms.`);
  return { name, unit, labels, peaks: parts.map((part) => Number(part[2])) };
}

function table(rules: readonly RegExpExecArray[], inputs: [Variable, Variable], output: Variable): number[][] {
  const made = inputs[0].labels.map(() => inputs[1].labels.map(() => -1));
  for (const rule of rules) {
    const [i, j, term] = [...inputs, output].map((one, n) => {
      const at = one.labels.indexOf(rule[n + 1]!);
      if (at < 0) throw new Error(`The ${one.name} has no term ${rule[n + 1]}, which “${rule[0]}” names.`);
      return at;
    }) as [number, number, number];
    if (made[i]![j]! >= 0) throw new Error(`${ruleName(inputs, i, j)} is given twice.`);
    made[i]![j] = term;
  }
  return made;
}

/** Return the text of a rule set. Pairs without a rule have no line. */
export function write(rules: RuleSet): string {
  const [a, b] = rules.inputs,
    { output } = rules;
  const lines = [`method ${rules.method}`, lineOf("input", a), lineOf("input", b), lineOf("output", output)];
  for (const [i, first] of a.labels.entries())
    for (const [j, second] of b.labels.entries()) {
      const term = output.labels[rules.table[i]![j]!];
      if (term !== undefined) lines.push(`rule ${first}, ${second}: ${term}`);
    }
  return `${lines.join("\n")}\n`;
}

function lineOf(kind: string, one: Variable): string {
  return `${kind} ${one.name} ${one.unit}: ${one.labels.map((label, n) => `${label} ${numeral(one.peaks[n]!)}`).join(", ")}`;
}

/** Return a number as the text has it: to thousandths, without zeros at the end. */
export function numeral(value: number): string {
  return value
    .toFixed(3)
    .replace(/\.?0+$/, "")
    .replace(/^-0$/, "0");
}

/** Return the name of the rule of a pair, with its number in Table 3. */
export function ruleName([first, second]: [Variable, Variable], i: number, j: number): string {
  return `Rule ${TERMS * i + j + 1} (${first.name} ${first.labels[i]}, ${second.name} ${second.labels[j]})`;
}

/** Return the CRC (XMODEM's, from 0) by which the rover names a rule set. */
export function crcOf(text: string): number {
  let crc = 0;
  for (const byte of new TextEncoder().encode(text)) {
    crc ^= byte << 8;
    for (let bit = 0; bit < 8; bit++) crc = ((crc << 1) ^ (crc & 0x8000 ? 0x1021 : 0)) & 0xffff;
  }
  return crc;
}
