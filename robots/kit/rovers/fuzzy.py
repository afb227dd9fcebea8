"""Fuzzy rules from two readings to a speed (Vasalya 2012, section 6): 25 rules, five terms a variable.

The terms of a variable are triangles: each has its peak where its neighbours end, and the outer two of an input stay
at one beyond their peaks, so the memberships of a reading always sum to one. A rule fires as much as the lesser of its
two memberships. Pure; SI units.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

TERMS = 5
SPEEDS = (0.0, 0.5)  # m/s: the lowest and the highest peak that an output may have
SPEED_STEP = 0.01  # m/s: how far apart the peaks of an output are at least
MOST = 9999.999  # of any reading, in its unit
Method = Literal["sugeno", "mamdani"]


@dataclass(frozen=True)
class Variable:
    """A reading or the speed: its name and unit, the labels of its five terms, and where each has its peak.

    Peaks are rounded to a thousandth of the unit, which is what the rover's firmware computes with. Raises ValueError
    unless there are five labels, all different, and five peaks that rise.
    """

    name: str
    unit: str
    labels: tuple[str, ...]
    peaks: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.labels) != TERMS or len(set(self.labels)) != TERMS:
            raise ValueError(f"The {self.name} needs {TERMS} different terms.")
        if len(self.peaks) != TERMS or not all(abs(peak) <= MOST for peak in self.peaks):
            raise ValueError(f"The {self.name} needs {TERMS} peaks, numbers of at most {MOST:g}.")
        object.__setattr__(self, "peaks", tuple(round(float(peak), 3) for peak in self.peaks))
        for label, peak, before in zip(self.labels[1:], self.peaks[1:], self.peaks, strict=False):
            if peak <= before:
                raise ValueError(f"The peaks of the {self.name} must rise; that of {label} does not.")


@dataclass(frozen=True)
class RuleSet:
    """Two inputs, a speed, and for each pair of input terms the number of an output term: `table[first][second]`.

    Raises ValueError with a sentence that names the rule, if a pair has none.
    """

    inputs: tuple[Variable, Variable]
    output: Variable
    table: tuple[tuple[int, ...], ...]
    method: Method = "sugeno"

    def __post_init__(self) -> None:
        if self.method not in ("sugeno", "mamdani"):
            raise ValueError("The method must be sugeno or mamdani.")
        if self.inputs[0].name == self.inputs[1].name:
            raise ValueError("The two inputs must be different readings.")
        peaks = self.output.peaks
        if (self.output.name, self.output.unit) != ("speed", "m/s"):
            raise ValueError("The output must be the speed, in m/s.")
        if peaks[0] < SPEEDS[0] or peaks[-1] > SPEEDS[1]:
            raise ValueError(f"The speeds must lie in {SPEEDS[0]:g} to {SPEEDS[1]:g} m/s.")
        if any(round(b - a, 3) < SPEED_STEP for a, b in pairwise(peaks)):
            raise ValueError(f"The speeds must be at least {SPEED_STEP:g} m/s apart.")
        if len(self.table) != TERMS or any(len(row) != TERMS for row in self.table):
            raise ValueError(f"The table must have {TERMS} rows of {TERMS} rules.")
        for i, row in enumerate(self.table):
            for j, term in enumerate(row):
                if type(term) is not int or not 0 <= term < TERMS:
                    raise ValueError(f"{rule_name(self.inputs, i, j)} is missing.")


def rule_name(inputs: tuple[Variable, Variable], i: int, j: int) -> str:
    """Return what people call the rule of the pair (i, j), with its number in Table 3."""
    first, second = inputs
    return f"Rule {TERMS * i + j + 1} ({first.name} {first.labels[i]}, {second.name} {second.labels[j]})"


def speed(rules: RuleSet, first: float, second: float) -> float:
    """Return the speed (m/s) for two readings, by the method of the rules.

    Raises ValueError for a reading that is not finite.
    """
    return (mamdani if rules.method == "mamdani" else sugeno)(rules, first, second)


def sugeno(rules: RuleSet, first: float, second: float) -> float:
    """Return the mean of the speeds of the rules that fire, weighted by how much each fires (zero-order Sugeno)."""
    i, s = _place(rules.inputs[0].peaks, first)
    j, t = _place(rules.inputs[1].peaks, second)
    (near, next_near), (far, next_far) = rules.table[i][j : j + 2], rules.table[i + 1][j : j + 2]
    peaks, r, u = rules.output.peaks, 1.0 - s, 1.0 - t
    a, b = r if r < u else u, r if r < t else t
    c, d = s if s < u else u, s if s < t else t
    return (a * peaks[near] + b * peaks[next_near] + c * peaks[far] + d * peaks[next_far]) / (a + b + c + d)


def mamdani(rules: RuleSet, first: float, second: float) -> float:
    """Return the centroid of the union of output triangles, each clipped at what its strongest rule fires (Mamdani).

    It is exact: the union is made of straight lines. The outer triangles of the output have two equal sides, so they
    reach beyond the first and the last peak by as much as to their neighbours; the centroid never lies beyond these
    peaks, and a rule that fires alone and fully gives its own speed where peaks are evenly spaced.
    """
    i, s = _place(rules.inputs[0].peaks, first)
    j, t = _place(rules.inputs[1].peaks, second)
    clipped = [0.0] * (TERMS + 2)  # with one that never fires on either side
    for m, weight in ((i, 1.0 - s), (i + 1, s)):
        for n, other in ((j, 1.0 - t), (j + 1, t)):
            term = rules.table[m][n] + 1
            clipped[term] = max(clipped[term], min(weight, other))
    peaks = rules.output.peaks
    ends = (2 * peaks[0] - peaks[1], *peaks, 2 * peaks[-1] - peaks[-2])
    area = moment = 0.0
    for n in range(TERMS + 1):
        if clipped[n] or clipped[n + 1]:
            size, centre = _union(clipped[n], clipped[n + 1])
            width = ends[n + 1] - ends[n]
            area += width * size
            moment += width * (size * ends[n] + width * centre)
    return moment / area


def surface(rules: RuleSet, n: int, m: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what figure 6 shows: n values of the first input, m of the second, and the speeds, shape (n, m)."""
    first, second = (np.linspace(v.peaks[0], v.peaks[-1], count) for v, count in zip(rules.inputs, (n, m), strict=True))
    return first, second, np.array([[speed(rules, a, b) for b in second.tolist()] for a in first.tolist()])


def _place(peaks: tuple[float, ...], reading: float) -> tuple[int, float]:
    """Return the term at or below the reading, with the membership of the next one; its own is the rest to 1."""
    if not math.isfinite(reading):
        raise ValueError("A reading must be a finite number.")
    if reading <= peaks[0]:
        return 0, 0.0
    if reading >= peaks[-1]:
        return TERMS - 2, 1.0
    n = bisect_right(peaks, reading) - 1
    return n, (reading - peaks[n]) / (peaks[n + 1] - peaks[n])


def _union(falling: float, rising: float) -> tuple[float, float]:
    """Return area and first moment, from 0 to 1, of what lies below either triangle between two neighbouring peaks.

    One falls from 1 to 0 and is clipped at `falling`, the other rises and is clipped at `rising`. One of these is at
    most a half, because two rules that fire more would need two memberships of one reading above a half.
    """
    corners = sorted((0.0, 1.0 - falling, 1.0 - rising, falling, rising, 1.0))
    heights = [max(min(falling, 1.0 - x), min(rising, x)) for x in corners]
    area = moment = 0.0
    for n in range(len(corners) - 1):
        a, b, f, g = corners[n], corners[n + 1], heights[n], heights[n + 1]
        area += (b - a) * (f + g) / 2
        moment += (b - a) * (f * (2 * a + b) + g * (a + 2 * b)) / 6
    return area, moment


LABELS = ("VN", "N", "M", "F", "VF")  # very near, near, medium, far, very far
PAPER = RuleSet(
    (
        Variable("infrared", "m", LABELS, (0.15, 0.30, 0.45, 0.60, 0.75)),  # Table 1
        Variable("sonar", "m", LABELS, (2.0, 4.0, 6.0, 8.0, 10.0)),
    ),
    Variable("speed", "m/s", ("VS", "S", "M", "F", "VF"), (0.08, 0.16, 0.24, 0.32, 0.40)),  # Table 2
    (
        (0, 0, 0, 0, 0),  # Table 3: infrared very near, sonar from very near to very far
        (0, 1, 1, 1, 1),
        (0, 1, 2, 2, 2),
        (0, 1, 2, 3, 3),
        (0, 1, 2, 3, 4),
    ),
)
