/** The editor of the rover's rules: table, peaks, text and surface of one set; sent while the rover drives. */
import { allow, byId, facts, make, type RobotPage, say } from "/static/farhand/v1/console.js";
import { firing, type Method, type RuleSet, speed, type Variable } from "./fuzzy.ts";
import "./rules.css";
import { RuleMemory } from "./rule_memory.ts";
import { braking, type Braking, type Made, READINGS, type Wrong, wrongIn } from "./rules_check.ts";
import { parse, write } from "./rules_text.ts";
import { cm, Surface } from "./surface.ts";
import { plainTerm } from "./terms.ts";
import { decimals, gettext, translate } from "/static/farhand/v1/text.js";

const KIND = "rules";
/** Where the terms of a reading have their peaks when it is chosen; those of infrared and sonar are the paper's. */
const PEAKS: Readonly<Record<string, readonly number[]>> = {
  infrared: [0.15, 0.3, 0.45, 0.6, 0.75],
  sonar: [2, 4, 6, 8, 10],
  battery: [6.4, 6.8, 7.2, 7.6, 8],
  temperature: [10, 15, 20, 25, 30],
  humidity: [20, 35, 50, 65, 80],
  light: [10, 30, 50, 70, 90],
};

export class RulesPanel {
  private paper =
    (facts.commands.find(({ kind }) => kind === KIND) as { default?: { text: string } | null } | undefined)?.default?.text ?? "";
  private known!: RuleMemory;
  private rules!: RuleSet;
  private wrong: Wrong[] = [];
  private unread = ""; // why the text cannot be read
  private selects: HTMLSelectElement[][] = [];
  private fields: HTMLInputElement[][] = [];
  private surface = new Surface(byId<SVGSVGElement>("hall-surface"));
  private text = byId<HTMLTextAreaElement>("hall-rules-text");
  private brakes: Braking;
  private sentUnder = 0; // the grant under which rules are on their way; 0: none

  constructor(
    private page: RobotPage,
    made: Made,
  ) {
    this.brakes = braking(made);
    byId("hall-rules").hidden = !this.paper;
    if (!this.paper) return;
    this.known = new RuleMemory(this.paper);
    for (const select of this.inputs()) {
      for (const name of Object.keys(READINGS)) select.append(new Option(translate(name), name));
      select.addEventListener("change", () => this.choose(Number(select.dataset["input"]), select.value));
    }
    const method = byId<HTMLSelectElement>("hall-rules-method");
    method.addEventListener("change", () => this.changed({ ...this.rules, method: method.value as Method }));
    this.text.addEventListener("input", () => this.read(this.text.value));
    byId("hall-rules-paper").addEventListener("click", () => this.changed(parse(this.paper)));
    page.on("rules-send", () => this.send(write(this.rules)));
    page.on("rules-back", () => this.send(this.paper));
    this.changed(parse(this.paper));
  }

  /** Show what the newest readings give, by this set and by the one in force. */
  state(): void {
    if (!this.paper) return;
    const [first, second] = this.rules.inputs.map(({ name }) => this.page.value(name));
    const known = first !== undefined && second !== undefined && !this.wrong.some(({ variable }) => variable !== undefined);
    this.surface.place(known ? [first, second] : null);
    const now = new Set(known ? firing(this.rules, first, second).map(([i, j]) => `${i},${j}`) : []);
    for (const [i, row] of this.selects.entries())
      for (const [j, select] of row.entries()) select.parentElement!.classList.toggle("fires", now.has(`${i},${j}`));
    const crc = this.page.value(KIND),
      inForce = crc === undefined ? undefined : this.known.get(crc);
    say(byId("hall-rules-force"), force(crc, inForce !== undefined));
    if (!known) return say(byId("hall-rules-ghost"), "");
    const here = this.rules.inputs.map(({ name, unit }, n) => `${translate(name)} ${decimals(n ? second : first, 2)} ${unit}`).join(", ");
    const values = { readings: here, speed: told(this.by(this.rules)) };
    const words =
      inForce === undefined
        ? gettext("Now: {readings}. By the set shown here {speed}.", values)
        : gettext("Now: {readings}. By the set shown here {speed}, by the set in force {other}.", {
            ...values,
            other: told(this.by(parse(inForce))),
          });
    say(byId("hall-rules-ghost"), words);
  }

  draw(): void {
    if (!this.paper) return;
    const onWay = this.sentUnder !== 0 && this.sentUnder === this.page.grant;
    const why = this.page.whyNot(KIND) || (onWay ? gettext("The rules are on their way to the rover.") : "");
    const first = this.unread || translate(this.wrong[0]?.words ?? "");
    allow(document.querySelector<HTMLElement>("[data-command=rules-send]")!, why || first);
    allow(document.querySelector<HTMLElement>("[data-command=rules-back]")!, why);
  }

  private by(rules: RuleSet): number | undefined {
    const [a, b] = rules.inputs.map(({ name }) => this.page.value(name));
    return a === undefined || b === undefined ? undefined : speed(rules, a, b);
  }

  private send(text: string): void {
    const seq = this.page.command(KIND, { text });
    if (!seq) return;
    this.sentUnder = this.page.grant;
    this.page.ladder.whenEnded(this.page.grant, seq, () => (this.sentUnder = 0));
    this.known.add(text);
    this.draw();
    if (text === this.paper) this.changed(parse(text));
  }

  private inputs(): NodeListOf<HTMLSelectElement> {
    return byId("hall-rules").querySelectorAll<HTMLSelectElement>("[data-input]");
  }

  /** Choose another reading for an input; if it is the other input, the two change places. */
  private choose(n: number, name: string): void {
    const [first, second] = this.rules.inputs;
    if (this.rules.inputs[1 - n]!.name === name) {
      const table = first.labels.map((_, i) => second.labels.map((__, j) => this.rules.table[j]![i]!));
      return this.changed({ ...this.rules, inputs: [second, first], table });
    }
    const one: Variable = { name, unit: READINGS[name]!, labels: this.rules.inputs[n]!.labels, peaks: [...PEAKS[name]!] };
    this.changed({ ...this.rules, inputs: n ? [first, one] : [one, second] });
  }

  private read(text: string): void {
    try {
      this.changed(parse(text), true);
    } catch (error) {
      this.unread = translate((error as Error).message);
      say(byId("hall-rules-said"), this.unread);
      this.draw();
    }
  }

  /** Show another set. `typed`: it was typed as text, which stays as it is. */
  private changed(rules: RuleSet, typed = false): void {
    const names = (one?: RuleSet): string => (one ? [...one.inputs, one.output].map((v) => `${v.name} ${v.labels.join(" ")}`).join() : "");
    const same = names(this.rules) === names(rules);
    this.rules = rules;
    this.unread = "";
    if (!same) this.build();
    const { inputs, output, table } = rules;
    if (!typed) this.text.value = write(rules);
    say(byId("hall-rules-said"), "");
    byId<HTMLSelectElement>("hall-rules-method").value = rules.method;
    for (const select of this.inputs()) select.value = inputs[Number(select.dataset["input"])]!.name;
    for (const [i, row] of this.selects.entries()) for (const [j, select] of row.entries()) this.put(select, table[i]![j]!);
    for (const [n, one] of [...inputs, output].entries())
      for (const [k, field] of this.fields[n]!.entries()) {
        if (document.activeElement !== field) field.value = String(one.peaks[k]);
        for (const place of byId("hall-rules").querySelectorAll(`[data-peak="${n},${k}"]`)) say(place, String(one.peaks[k]));
      }
    this.judge();
    if (!this.wrong.some(({ variable }) => variable !== undefined)) this.surface.show(rules);
    this.state();
    this.draw();
  }

  /** Choose a rule's term; it stands over the narrow field in as many lines as it needs. */
  private put(select: HTMLSelectElement, term: number): void {
    const { name, labels } = this.rules.output,
      label = labels[term] ?? "–";
    select.value = String(term);
    say(select.nextElementSibling as HTMLElement, called(name, label));
  }

  /** Say what is wrong, and where. */
  private judge(): void {
    this.wrong = wrongIn(this.rules, this.brakes);
    for (const field of [...this.selects.flat(), ...this.fields.flat()]) {
      field.removeAttribute("aria-invalid");
      field.removeAttribute("aria-describedby");
    }
    const items = this.wrong.map(({ words, rule, variable, peak }, n) => {
      const item = make("li", { id: `hall-rules-wrong-${n}` }, translate(words)),
        field = rule ? this.selects[rule[0]]![rule[1]] : this.fields[variable ?? -1]?.[peak ?? 0];
      field?.setAttribute("aria-invalid", "true");
      field?.setAttribute("aria-describedby", item.id);
      return item;
    });
    const list = byId("hall-rules-wrong");
    if (items.map((item) => item.textContent).join() !== [...list.children].map((item) => item.textContent).join())
      list.replaceChildren(...items);
  }

  /** Make the table of the rules and that of the peaks for the present readings and terms. */
  private build(): void {
    const { inputs, output } = this.rules,
      [first, second] = inputs,
      table = byId<HTMLTableElement>("hall-rules-table");
    const corner = make("th", {}, `${translate(first.name)} ↓ ${translate(second.name)} →`);
    table.tHead!.replaceChildren(make("tr", {}, corner, ...second.labels.map((label, j) => heading(label, "col", `1,${j}`, second.name))));
    this.selects = first.labels.map((label, i) =>
      second.labels.map((other, j) => this.select(i, j, spoken(first.name, label, second.name, other))),
    );
    const rows = first.labels.map((label, i) =>
      make(
        "tr",
        {},
        heading(label, "row", `0,${i}`, first.name),
        ...this.selects[i]!.map((select) => make("td", {}, select, make("span", { "aria-hidden": "true" }))),
      ),
    );
    table.tBodies[0]!.replaceChildren(...rows);
    this.fields = [];
    byId<HTMLTableElement>("hall-rules-peaks").tBodies[0]!.replaceChildren(...[first, second, output].map((one, n) => this.peaks(one, n)));
  }

  /** Return the choice of the term of a rule. */
  private select(i: number, j: number, label: string): HTMLSelectElement {
    const options = this.rules.output.labels.map((term, n) => new Option(termOf(this.rules.output.name, term), String(n)));
    const select = make("select", { "aria-label": label }, ...options, new Option("–", "-1"));
    select.addEventListener("change", () => {
      const table = this.rules.table.map((line) => [...line]);
      table[i]![j] = Number(select.value);
      this.changed({ ...this.rules, table });
    });
    return select;
  }

  private peaks(one: Variable, n: number): HTMLTableRowElement {
    const fields = one.labels.map((label, k) => {
      const name = gettext("{name}: peak of {term}, in {unit}", {
        name: translate(one.name),
        term: termOf(one.name, label),
        unit: one.unit,
      });
      const field = make("input", { type: "number", step: "any", inputmode: "decimal", "aria-label": name });
      field.addEventListener("input", () => {
        const put = (v: Variable, m: number): Variable =>
          m === n ? { ...v, peaks: v.peaks.map((p, at) => (at === k ? thousandths(field.valueAsNumber) : p)) } : v;
        const [a, b] = this.rules.inputs;
        this.changed({ ...this.rules, inputs: [put(a, 0), put(b, 1)], output: put(this.rules.output, 2) });
      });
      return field;
    });
    this.fields.push(fields);
    return make("tr", {}, heading(`${translate(one.name)} (${one.unit})`, "row"), ...fields.map((field) => make("td", {}, field)));
  }
}

function spoken(first: string, label: string, second: string, other: string): string {
  const values = { first: translate(first), term: called(first, label), second: translate(second), other: called(second, other) };
  return gettext("Speed if {first} is {term} and {second} is {other}", values);
}

/** Return a term's plain word; the term itself where there is none. */
function called(reading: string, term: string): string {
  return plainTerm(reading, term) || term;
}

/** Return a term with its plain word. */
function termOf(reading: string, term: string): string {
  const word = plainTerm(reading, term);
  return word ? `${term}, ${word}` : term;
}

/** Return a heading: for a term of `reading` its plain word, with the paper's beside it, small. */
function heading(label: string, scope: string, peak = "", reading = ""): HTMLElement {
  const word = reading ? plainTerm(reading, label) : "";
  const words = word ? [`${word} `, make("small", {}, label)] : [label];
  return make("th", { scope }, ...words, ...(peak ? [make("span", { "data-peak": peak })] : []));
}

function force(crc: number | undefined, known: boolean): string {
  if (crc === undefined) return gettext("Which rules are in force is not known.");
  if (crc === 0) return gettext("In force: the paper's rules.");
  const number = crc.toString(16).toUpperCase().padStart(4, "0");
  return known
    ? gettext("In force: rule set {number}, sent from here.", { number })
    : gettext("In force: rule set {number}, sent by somebody else.", { number });
}

function told(speed: number | undefined): string {
  return speed === undefined || Number.isNaN(speed) ? gettext("not known") : `${cm(speed)} cm/s`;
}

function thousandths(value: number): number {
  return Math.round(value * 1000) / 1000;
}
