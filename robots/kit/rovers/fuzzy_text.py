"""The text of a rule set: a person can read it, and the rover's firmware parses the same.

    method sugeno
    input infrared m: VN 0.15, N 0.3, M 0.45, F 0.6, VF 0.75
    input sonar m: VN 2, N 4, M 6, F 8, VF 10
    output speed m/s: VS 0.08, S 0.16, M 0.24, F 0.32, VF 0.4
    rule VN, VN: VS

and so on, one line for each of the 25 pairs, in any order. Empty lines and lines that begin with # say nothing.
Printable ASCII, at most 2048 characters and 64 lines; numbers have at most four digits before and three after the
point.
"""

import re

from robots.kit.rovers.fuzzy import TERMS, Method, RuleSet, Variable, rule_name

LONGEST = 2048  # characters
LINES = 64
LETTERS = re.compile(r"[ -~\n]*")
LABEL = r"[A-Za-z](?:[A-Za-z -]{0,10}[A-Za-z])?"
TERM = re.compile(rf"({LABEL}) (-?[0-9]{{1,4}}(?:\.[0-9]{{1,3}})?)")
VARIABLE = re.compile(r"(input|output) ([a-z]{1,16}) ([A-Za-z/%]{1,4}): (.*)")
METHODS: dict[str, Method] = {"method sugeno": "sugeno", "method mamdani": "mamdani"}
RULE = re.compile(rf"rule ({LABEL}), ({LABEL}): ({LABEL})")


def parse(text: str) -> RuleSet:
    """Return the rule set of a text. Raises ValueError with a sentence for a person."""
    if len(text) > LONGEST or text.count("\n") >= LINES or not LETTERS.fullmatch(text):
        raise ValueError(f"A rule set has at most {LONGEST} characters, all printable ASCII, in {LINES} lines.")
    methods: list[Method] = []
    variables: dict[str, list[Variable]] = {"input": [], "output": []}
    rules: list[re.Match[str]] = []
    for line in text.split("\n"):
        if match := RULE.fullmatch(line):
            rules.append(match)
        elif match := VARIABLE.fullmatch(line):
            variables[match[1]].append(_variable(match))
        elif line in METHODS:
            methods.append(METHODS[line])
        elif line and not line.startswith("#"):
            raise ValueError(f"This is no line of a rule set: {line[:60]!a}.")
    inputs, outputs = variables["input"], variables["output"]
    if (len(methods), len(inputs), len(outputs)) != (1, 2, 1):
        raise ValueError("A rule set has one method, two inputs and one output.")
    pair = inputs[0], inputs[1]
    return RuleSet(pair, outputs[0], _table(rules, pair, outputs[0]), methods[0])


def write(rules: RuleSet) -> str:
    """Return the text of a rule set; `parse` gives the same rule set back.

    Raises ValueError for a name, unit or label that the text cannot have.
    """
    a, b = rules.inputs
    lines = [f"method {rules.method}", _line("input", a), _line("input", b), _line("output", rules.output)]
    for i, first in enumerate(a.labels):
        for j, second in enumerate(b.labels):
            lines.append(f"rule {first}, {second}: {rules.output.labels[rules.table[i][j]]}")
    text = "\n".join(lines) + "\n"
    parse(text)
    return text


def _variable(match: re.Match[str]) -> Variable:
    """Return the variable of an `input` or `output` line."""
    terms = [TERM.fullmatch(term) for term in match[4].split(", ")]
    if not all(terms):
        raise ValueError(
            f"The terms of the {match[2]} must be a label of at most 12 letters, spaces and hyphens and a number each."
        )
    found = [term for term in terms if term]
    return Variable(match[2], match[3], tuple(t[1] for t in found), tuple(float(t[2]) for t in found))


def _table(
    rules: list[re.Match[str]], inputs: tuple[Variable, Variable], output: Variable
) -> tuple[tuple[int, ...], ...]:
    """Return the numbers of the output's terms; a pair without a rule has -1."""
    table = [[-1] * TERMS for _ in range(TERMS)]
    for rule in rules:
        for label, variable in zip(rule.groups(), (*inputs, output), strict=True):
            if label not in variable.labels:
                raise ValueError(f"The {variable.name} has no term {label}, which {rule[0]!r} names.")
        i, j = (variable.labels.index(label) for label, variable in zip(rule.groups()[:2], inputs, strict=True))
        if table[i][j] >= 0:
            raise ValueError(f"{rule_name(inputs, i, j)} is given twice.")
        table[i][j] = output.labels.index(rule[3])
    return tuple(map(tuple, table))


def _line(kind: str, variable: Variable) -> str:
    terms = zip(variable.labels, variable.peaks, strict=True)
    return f"{kind} {variable.name} {variable.unit}: " + ", ".join(f"{label} {_number(peak)}" for label, peak in terms)


def _number(value: float) -> str:
    return f"{value:.3f}".rstrip("0").rstrip(".")
