"""The rules as the rover's firmware keeps and evaluates them: whole numbers only, as its processor has them.

Readings and peaks are thousandths of their unit (mm, mm/s), weights are shares of 16384. Of the format of the text:
robots/kit/rovers/fuzzy_text.py; this is a parser of its own.
"""

from binascii import crc_hqx
from bisect import bisect_right
from itertools import pairwise
from typing import NamedTuple

WHOLE = 1 << 14  # the weight 1: fine enough for the centroid of a triangle of 10 mm/s beside one of 490, in 64 bits
TERMS, RULES = 5, 25
LONGEST, LINES, LABEL = 2048, 64, 12
FASTEST_MM_S, APART_MM_S = 500, 10
UNITS = {
    "infrared": "m", "sonar": "m", "battery": "V", "temperature": "C", "humidity": "%", "light": "%",
}  # fmt: skip
LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")


class Terms(NamedTuple):
    """The labels and peaks (thousandths) of a variable."""

    labels: tuple[str, ...]
    peaks: tuple[int, ...]


class RuleSet(NamedTuple):
    """The rules in force. `table` has the number of an output term for each pair, row by row; `crc` is of the text."""

    inputs: tuple[str, str]
    first: Terms
    second: Terms
    speeds: Terms
    table: tuple[int, ...]
    mamdani: bool
    crc: int

    @classmethod
    def parse(cls, text: str) -> "RuleSet":
        """Return the rule set of a text. Raises ValueError with a sentence."""
        if len(text) > LONGEST or text.count("\n") >= LINES or any(c != "\n" and not " " <= c <= "~" for c in text):
            raise ValueError("The text is too long, or has other characters than printable ASCII.")
        methods: list[str] = []
        variables: list[tuple[str, str, Terms]] = []
        rules: list[str] = []
        for line in text.split("\n"):
            word, _, rest = line.partition(" ")
            if word == "method" and rest in ("sugeno", "mamdani"):
                methods.append(rest)
            elif word in ("input", "output"):
                variables.append((word, *_variable(rest)))
            elif word == "rule":
                rules.append(rest)
            elif line and line[0] != "#":
                raise ValueError("A line does not belong to a rule set.")
        inputs = [(name, terms) for word, name, terms in variables if word == "input"]
        outputs = [(name, terms) for word, name, terms in variables if word == "output"]
        if (len(methods), len(inputs), len(outputs)) != (1, 2, 1):
            raise ValueError("A rule set has one method, two inputs and one output.")
        (a, first), (b, second) = inputs
        speeds = _speeds(*outputs[0])
        if a == b or "speed" in (a, b):
            raise ValueError("The two inputs must be different readings.")
        table = _table(rules, first, second, speeds)
        return cls((a, b), first, second, speeds, table, methods[0] == "mamdani", crc_hqx(text.encode("ascii"), 0))

    def speed_mm_s(self, first: int, second: int) -> int:
        """Return the speed for two readings in thousandths of their units."""
        i, low, high = _weights(self.first.peaks, first)
        j, left, right = _weights(self.second.peaks, second)
        fired = [
            (min(a, b), self.table[TERMS * m + n])
            for m, a in ((i, low), (i + 1, high))
            for n, b in ((j, left), (j + 1, right))
        ]
        peaks = self.speeds.peaks
        if self.mamdani:
            return _centroid(peaks, fired)
        return _divided(sum(w * peaks[term] for w, term in fired), sum(w for w, _ in fired))


def _divided(dividend: int, divisor: int) -> int:
    """Return the quotient, rounded to the nearest."""
    return (2 * dividend + divisor) // (2 * divisor)


def _weights(peaks: tuple[int, ...], reading: int) -> tuple[int, int, int]:
    """Return the lower of the two terms that a reading is between, and the weights of both, which sum to WHOLE."""
    inside = min(max(reading, peaks[0]), peaks[-1])
    n = min(bisect_right(peaks, inside) - 1, TERMS - 2)
    high = _divided((inside - peaks[n]) * WHOLE, peaks[n + 1] - peaks[n])
    return n, WHOLE - high, high


def _centroid(peaks: tuple[int, ...], fired: list[tuple[int, int]]) -> int:
    """Return the centroid (mm/s) of the clipped triangles; the outer two have equal sides."""
    weights = [max((w for w, term in fired if term == n), default=0) for n in range(TERMS)]
    area = moment = 0  # both times 2 * WHOLE^2, the moment times 3 besides; from the first end, in (mm/s)^2
    ends = [2 * peaks[0] - peaks[1], *peaks, 2 * peaks[-1] - peaks[-2]]
    for n, (a, b) in enumerate(zip([0, *weights], [*weights, 0], strict=True)):
        width = ends[n + 1] - ends[n]
        steps = _profile(max(a, b), min(a, b))
        for (t, f), (u, g) in pairwise(steps):
            piece = (u - t) * (f + g) * width
            area += piece
            away = (u - t) * (f * (2 * t + u) + g * (t + 2 * u)) * width // WHOLE  # from the side of the higher one
            if a < b:
                away = 3 * piece - away
            moment += 3 * piece * (ends[n] - ends[0]) + away * width
    return ends[0] + _divided(moment, 3 * area)


def _profile(high: int, low: int) -> list[tuple[int, int]]:
    """Return the corners of the union between two neighbours' peaks, seen from the one that is clipped less.

    `low` is at most half: two rules that both fire more would need two memberships of one reading above a half.
    """
    return [(0, high), (WHOLE - high, high), (WHOLE - low, low), (WHOLE, low)]


def _variable(text: str) -> tuple[str, Terms]:
    """Return name and terms of `infrared m: VN 0.15, ...`."""
    head, colon, terms = text.partition(": ")
    name, _, unit = head.partition(" ")
    if not colon or {**UNITS, "speed": "m/s"}.get(name) != unit:
        raise ValueError("A variable is none of this rover's, or in another unit.")
    pairs = [term.rpartition(" ") for term in terms.split(", ")]
    labels, peaks = tuple(_label(p[0]) for p in pairs), tuple(_thousandths(p[2]) for p in pairs)
    if len(pairs) != TERMS or len(set(labels)) != TERMS or sorted(set(peaks)) != list(peaks):
        raise ValueError(f"The {name} needs five different terms whose peaks rise.")
    return name, Terms(labels, peaks)


def _speeds(name: str, terms: Terms) -> Terms:
    """Return the terms if they are speeds that the motors know."""
    slow, fast = terms.peaks[0], terms.peaks[-1]
    if name != "speed" or slow < 0 or fast > FASTEST_MM_S:
        raise ValueError("The output must be a speed in 0 to 0.5 m/s.")
    if any(b - a < APART_MM_S for a, b in pairwise(terms.peaks)):
        raise ValueError("The speeds must be at least 0.01 m/s apart.")
    return terms


def _table(rules: list[str], first: Terms, second: Terms, speeds: Terms) -> tuple[int, ...]:
    """Return the output terms of all pairs."""
    table = [-1] * RULES
    for rule in rules:
        pair, colon, then = rule.partition(": ")
        one, comma, other = pair.partition(", ")
        if not (colon and comma) or one not in first.labels or other not in second.labels or then not in speeds.labels:
            raise ValueError("A rule names a term that is none.")
        n = TERMS * first.labels.index(one) + second.labels.index(other)
        if table[n] >= 0:
            raise ValueError(f"Rule {n + 1} is given twice.")
        table[n] = speeds.labels.index(then)
    if -1 in table:
        raise ValueError(f"Rule {table.index(-1) + 1} is missing.")
    return tuple(table)


def _label(text: str) -> str:
    if not 0 < len(text) <= LABEL or {text[0], text[-1]} - LETTERS or set(text) - LETTERS - set(" -"):
        raise ValueError("A label is 1 to 12 letters, spaces and hyphens.")
    return text


def _thousandths(text: str) -> int:
    """Return a number of at most four digits before and three after the point, times 1000."""
    digits = text.removeprefix("-")
    before, point, after = digits.partition(".")
    if not (before.isdigit() and len(before) <= 4) or (point and not (after.isdigit() and len(after) <= 3)):
        raise ValueError("A peak is no number with at most four digits before and three after the point.")
    value = 1000 * int(before) + int(after.ljust(3, "0") if point else 0)
    return -value if text[0] == "-" else value
