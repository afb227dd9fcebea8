/**
 * Texts in the reader's language. `gettext` and `ngettext` are for texts of the page's own scripts; `translate` is for
 * sentences of the server and of workers, which come in English with names and numbers already in them: the rule is
 * that of `robots/kit/sentences.py`. English needs no catalogue; another language's is a script before all modules.
 */

type Values = Readonly<Record<string, string | number>>;
type Entry = { words: string[]; names: string[]; text: string };
interface Catalogue {
  catalog: Readonly<Record<string, string | string[]>>;
  pluralidx(count: number): number;
}

const catalogue = (globalThis as { texts?: Catalogue }).texts;
const PLACE = /\{(\w+)\}/;
const ENDS = [/(?<=[.!?]) /, /(?<=[:;,]) /],
  SENTENCES = /[.!?] .*[^.!?]$/s,
  NUMBER = /^[-+]?[0-9]/,
  DECIMAL = /^([-+]?[0-9]+)\.([0-9]+)(?=$| |°|%)/,
  NUMERAL = /^[-+]?[0-9][0-9.e+-]*$/,
  WORD = /\p{L}/gu;
const FEW = 6,
  LONGEST = 600,
  DEEPEST = 6;

/** Return a text of ours, with the values in its placeholders. */
export function gettext(text: string, values: Values = {}): string {
  const entry = catalogue?.catalog[text];
  return filled(typeof entry === "string" && entry ? entry : text, values);
}

/** Return one of two texts by the count, which is also the value of `{count}`. */
export function ngettext(one: string, many: string, count: number, values: Values = {}): string {
  const forms = catalogue?.catalog[one];
  const form = catalogue && Array.isArray(forms) ? forms[catalogue.pluralidx(count)] : "";
  return filled(form || (count === 1 ? one : many), { count, ...values });
}

/** Return a sentence of the server in the reader's language; in English where nothing fits. */
export function translate(text: string): string {
  if (!catalogue) return text;
  const before = memory.get(text);
  if (before !== undefined) return before;
  if (memory.size > 2000) memory.clear();
  sentences ??= new Sentences(catalogue.catalog, decimalMark());
  const now = sentences.translate(text);
  memory.set(text, now);
  return now;
}

/** Return the language of the page, for dates and numbers. */
export function language(): string {
  return (globalThis as { document?: Document }).document?.documentElement.lang || "en";
}

/** Return a number with so many decimals, as the reader's language writes them. */
export function decimals(value: number, digits: number): string {
  return value.toFixed(digits).replace(".", decimalMark());
}

function decimalMark(): string {
  return (mark ??= new Intl.NumberFormat(language()).formatToParts(0.5).find(({ type }) => type === "decimal")?.value ?? ".");
}

function filled(text: string, values: Values): string {
  return text.replace(new RegExp(PLACE, "g"), (place, name: string) => (name in values ? String(values[name]) : place));
}

/** The sentences of one language. */
export class Sentences {
  readonly #whole = new Map<string, string>();
  readonly #byWord = new Map<string, Entry[]>();
  readonly #any: Entry[]; // they fit a text whatever its first word is

  readonly #decimal: string;

  /** `mark` stands between whole part and decimals of a number in a sentence. */
  constructor(texts: Readonly<Record<string, string | string[]>>, mark = ".") {
    this.#decimal = `$1${mark}$2`;
    const entries: Entry[] = [];
    for (const [text, entry] of Object.entries(texts)) {
      if (typeof entry !== "string" || !entry || !text) continue;
      const parts = text.split(PLACE);
      if (parts.length === 1) this.#whole.set(text, entry);
      else entries.push({ words: parts.filter((_, i) => i % 2 === 0), names: parts.filter((_, i) => i % 2 === 1), text: entry });
    }
    const size = (entry: Entry): number => entry.words.reduce((sum, word) => sum + word.length, 0);
    const order = (a: Entry, b: Entry): number => size(b) - size(a) || compare(a.words, b.words);
    entries.sort(order);
    for (const entry of entries) {
      const word = firstWord(entry.words[0] ?? "");
      this.#byWord.set(word, [...(this.#byWord.get(word) ?? []), entry]);
    }
    this.#any = this.#byWord.get("") ?? [];
    this.#byWord.delete("");
    for (const [word, own] of this.#byWord) this.#byWord.set(word, [...own, ...this.#any].sort(order));
  }

  /** Return the text in this language; in English where the catalogue has nothing that fits. */
  translate(text: string, depth = 0): string {
    if (text.length > LONGEST || depth > DEEPEST) return text;
    const known = this.#either(text, depth);
    if (known !== undefined) return known;
    for (const end of ENDS) {
      const cut = text.search(end);
      if (cut >= 0) return this.#parts(text.slice(0, cut), text.slice(cut + 1), end, depth + 1).join(" ");
    }
    const bare = text.replace(/[.,:;]+$/, "");
    return bare === text ? text : this.translate(bare, depth + 1) + text.slice(bare.length);
  }

  /** Return the translation of an entry that fits the whole text. */
  #known(text: string, depth: number): string | undefined {
    const whole = this.#whole.get(text);
    if (whole !== undefined) return whole;
    for (const entry of this.#candidates(text)) {
      const values = fit(entry.words, text);
      if (values?.every((value, i) => this.#mayBe(entry.names[i] ?? "", value, depth)))
        return filled(entry.text, Object.fromEntries(entry.names.map((name, i) => [name, this.#value(name, values[i] ?? "", depth)])));
    }
    return undefined;
  }

  /** Return the translations of the parts of a text: what follows a part may fit an entry as a whole. */
  #parts(first: string, text: string, end: RegExp, depth: number): string[] {
    const done = [this.translate(first, depth)];
    for (let rest = text; ;) {
      const cut = this.#either(rest, depth) === undefined ? rest.search(end) : -1;
      done.push(this.translate(cut < 0 ? rest : rest.slice(0, cut), depth));
      if (cut < 0) return done;
      rest = rest.slice(cut + 1);
    }
  }

  /** Return `#known`, also with the first letter in the other case: a sentence may stand in another. */
  #either(text: string, depth: number): string | undefined {
    const known = this.#known(text, depth) ?? this.#other(text, depth);
    if (known !== undefined || !SENTENCES.test(text) || text.endsWith(":")) return known;
    return this.#either(`${text}.`, depth)?.replace(/\.$/, ""); // its last full stop is another's
  }

  #other(text: string, depth: number): string | undefined {
    const first = text.slice(0, 1);
    if (!/[A-Za-z]/.test(first)) return undefined;
    const small = first === first.toLowerCase();
    const known = this.#known((small ? first.toUpperCase() : first.toLowerCase()) + text.slice(1), depth);
    return small || !known ? known : known.slice(0, 1).toUpperCase() + known.slice(1);
  }

  #value(name: string, value: string, depth: number): string {
    return /^(written|quoted)/.test(name) ? value : this.translate(value.replace(DECIMAL, this.#decimal), depth + 1);
  }

  /** Tell whether the placeholder may stand for the value: a number; no sentence and a part of the next one. */
  #mayBe(name: string, value: string, depth: number): boolean {
    if (name.startsWith("number")) return NUMERAL.test(value);
    return name.startsWith("quoted") || !SENTENCES.test(value) || (depth < DEEPEST && this.#either(value, depth + 1) !== undefined);
  }

  #candidates(text: string): Entry[] {
    return this.#byWord.get(text.split(" ", 1)[0] ?? "") ?? this.#any;
  }
}

/** Return what stands between the words, at least one character each; undefined if the text has other words. */
export function fit(words: readonly string[], text: string): string[] | undefined {
  const first = words[0] ?? "",
    last = words.at(-1) ?? "",
    numbers = !first && (words.join(" ").match(WORD) ?? []).length < FEW;
  if (!text.startsWith(first) || !text.endsWith(last) || text.length < first.length + last.length) return undefined;
  const values: string[] = [],
    end = text.length - last.length;
  let at = first.length;
  for (const word of words.slice(1, -1)) {
    const found = text.indexOf(word, at + 1);
    if (found < 0 || found + word.length > end) return undefined;
    values.push(text.slice(at, found));
    at = found + word.length;
  }
  values.push(text.slice(at, end));
  if (last.match(WORD) && values.at(-1)?.includes(last)) return undefined; // the text has the sentence twice
  return at < end && (!numbers || values.every((value) => NUMBER.test(value))) ? values : undefined;
}

function firstWord(start: string): string {
  const space = start.indexOf(" ");
  return space < 0 ? "" : start.slice(0, space);
}

function compare(a: readonly string[], b: readonly string[]): number {
  const [one, other] = [a.join("\0"), b.join("\0")];
  return one < other ? -1 : one > other ? 1 : 0;
}

const memory = new Map<string, string>();
let sentences: Sentences | undefined;
let mark: string | undefined; // between a number's whole part and its decimals
