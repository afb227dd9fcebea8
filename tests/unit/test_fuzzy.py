"""Fuzzy rules from two readings to a speed: the paper's table, bounds and continuity of any rule set, another library."""

import math
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from simpful import FuzzySet, FuzzySystem, LinguisticVariable, Triangular_MF

from robots.kit.rovers.fuzzy import PAPER, RuleSet, Variable, mamdani, speed, sugeno, surface
from tests.unit.fuzzy_sets import METHODS, cases, near, paper_readings, rule_sets

DIP = 0.007  # m/s: by how much the paper's speed falls at most while a reading grows


@given(st.integers(0, 4), st.integers(0, 4))
def test_a_rule_of_the_paper_has_the_lesser_of_its_two_indices(i, j):
    assert PAPER.table[i][j] == min(i, j)


@given(st.integers(0, 4), st.integers(0, 4), METHODS)
def test_at_the_peaks_of_a_pair_its_rule_alone_sets_the_speed(i, j, method):
    first, second = (v.peaks[n] for v, n in zip(PAPER.inputs, (i, j), strict=True))
    assert speed(replace(PAPER, method=method), first, second) == pytest.approx(PAPER.output.peaks[min(i, j)])


@given(cases)
def test_a_speed_lies_between_the_first_and_the_last_peak(case):
    rules, first, second = case
    assert rules.output.peaks[0] - 1e-9 <= speed(rules, first, second) <= rules.output.peaks[-1] + 1e-9


@given(cases)
def test_a_mean_lies_between_the_slowest_and_the_fastest_rule_that_fires(case):
    rules, first, second = case
    fire = [
        [n for n, m in enumerate(memberships(v, x)) if m > 0]
        for v, x in zip(rules.inputs, (first, second), strict=True)
    ]
    found = [rules.output.peaks[rules.table[i][j]] for i, j in product(*fire)]
    assert min(found) - 1e-9 <= sugeno(rules, first, second) <= max(found) + 1e-9


@given(rule_sets.filter(lambda rules: rules.method == "sugeno"), st.data())
def test_a_speed_jumps_nowhere(rules, data):
    """Each of the four weights changes by at most the step over the gap between two peaks, and they sum to one or more."""
    a, b = rules.inputs
    first, second, step = data.draw(near(a)), data.draw(near(b)), data.draw(st.floats(0, 1))
    gap = min(y - x for x, y in pairwise(a.peaks))
    range_of_speeds = rules.output.peaks[-1] - rules.output.peaks[0]
    moved = abs(sugeno(rules, first + step * gap, second) - sugeno(rules, first, second))
    assert moved <= 4 * range_of_speeds * (step + 1e-6)


@given(rule_sets, st.data())
def test_a_speed_jumps_at_no_peak(rules, data):
    a, b = rules.inputs
    first, second = data.draw(st.sampled_from(a.peaks)), data.draw(near(b))
    tiny = 1e-8 * min(y - x for x, y in pairwise(a.peaks))
    here = speed(rules, first, second)
    for beside in (first - tiny, first + tiny):
        assert speed(rules, beside, second) == pytest.approx(here, abs=1e-4)


@given(*paper_readings, st.floats(0, 8), st.floats(0, 8), METHODS)
def test_the_papers_speed_hardly_falls_while_a_reading_grows(first, second, more, farther, method):
    rules = replace(PAPER, method=method)
    here = speed(rules, first, second)
    assert speed(rules, first + more, second) >= here - DIP
    assert speed(rules, first, second + farther) >= here - DIP


@given(*paper_readings, st.floats(0, 8), st.floats(0, 8), st.integers(0, 4), st.integers(0, 4))
def test_the_papers_speed_never_falls_where_the_other_reading_is_at_a_peak(first, second, more, farther, i, j):
    (a, b) = (v.peaks[n] for v, n in zip(PAPER.inputs, (i, j), strict=True))
    assert sugeno(PAPER, first + more, b) >= sugeno(PAPER, first, b) - 1e-9
    assert sugeno(PAPER, a, second + farther) >= sugeno(PAPER, a, second) - 1e-9


def memberships(variable, reading):
    """Return the five memberships, the outer terms with shoulders, by interpolation between the peaks."""
    return [float(np.interp(reading, variable.peaks, np.eye(5)[n])) for n in range(5)]


def simpful_system(rules):
    """Return the same rules in simpful. A triangle of the first term begins where no reading is."""
    system = FuzzySystem(show_banner=False, operators=["AND_MIN"])
    for n, variable in enumerate(rules.inputs):
        low, *_, high = variable.peaks
        corners = (low - 1, *variable.peaks, high + 1)
        terms = [FuzzySet(function=Triangular_MF(*corners[k : k + 3]), term=f"t{k}") for k in range(5)]
        system.add_linguistic_variable(f"v{n}", LinguisticVariable(terms, universe_of_discourse=[low, high]))
    for k, peak in enumerate(rules.output.peaks):
        system.set_crisp_output_value(f"s{k}", peak)
    system.add_rules([
        f"IF (v0 IS t{i}) AND (v1 IS t{j}) THEN (v2 IS s{rules.table[i][j]})" for i in range(5) for j in range(5)
    ])  # fmt: skip
    return system


UNEVEN = RuleSet(
    (
        replace(PAPER.inputs[0], peaks=(0.12, 0.2, 0.5, 0.55, 0.8)),
        Variable("light", "%", PAPER.inputs[1].labels, (1, 7, 50, 51, 90)),
    ),
    replace(PAPER.output, peaks=(0.0, 0.05, 0.3, 0.35, 0.5)),
    ((4, 0, 1, 3, 2), (0, 4, 4, 0, 1), (2, 2, 0, 3, 1), (1, 3, 4, 2, 0), (3, 1, 0, 4, 2)),
)


@pytest.mark.parametrize("rules", [PAPER, UNEVEN], ids=["paper", "uneven"])
def test_a_surface_is_that_of_another_library(rules):
    system = simpful_system(rules)
    first, second, speeds = surface(rules, 25, 29)
    for (n, a), (m, b) in product(enumerate(first), enumerate(second)):
        system.set_variable("v0", a)
        system.set_variable("v1", b)
        assert speeds[n, m] == pytest.approx(float(system.Sugeno_inference(["v2"])["v2"]), abs=1e-6), (a, b)


@given(cases)
def test_a_centroid_is_that_of_the_union_in_small_steps(case):
    rules, first, second = case
    fires = [0.0] * 5
    for i, j in product(range(5), repeat=2):
        term = rules.table[i][j]
        fired = min(memberships(rules.inputs[0], first)[i], memberships(rules.inputs[1], second)[j])
        fires[term] = max(fires[term], fired)
    peaks = rules.output.peaks
    corners = (2 * peaks[0] - peaks[1], *peaks, 2 * peaks[-1] - peaks[-2])
    y = np.linspace(corners[0], corners[-1], 40_001)
    union = np.max([np.minimum(np.interp(y, corners, np.eye(7)[n + 1]), fires[n]) for n in range(5)], axis=0)
    assert mamdani(rules, first, second) == pytest.approx((union @ y) / union.sum(), abs=1e-4)


def test_a_surface_spans_the_peaks():
    first, second, speeds = surface(PAPER, 7, 9)
    assert (first[0], first[-1], second[0], second[-1]) == (0.15, 0.75, 2.0, 10.0)
    assert speeds.shape == (7, 9)
    assert speeds[1, 8] == speed(PAPER, first[1], second[8])
    assert (speeds[0] == 0.08).all()
    assert speeds[-1, -1] == 0.4


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("method", ["sugeno", "mamdani"])
def test_a_reading_that_is_none_is_refused(bad, method):
    for readings in ((bad, 5.0), (0.5, bad)):
        with pytest.raises(ValueError, match="A reading must be a finite number"):
            speed(replace(PAPER, method=method), *readings)


@pytest.mark.parametrize(
    ("peaks", "why"),
    [
        ((1, 2, 3, 3, 4), "must rise; that of F does not"),
        ((1, 2, 3, 2, 4), "must rise; that of F does not"),
        ((1, 1.0004, 3, 4, 5), "must rise; that of N does not"),  # the same in thousandths
        ((1, 2, 3, 4), "needs 5 peaks"),
        ((1, 2, 3, 4, math.nan), "needs 5 peaks"),
        ((1, 2, 3, 4, math.inf), "needs 5 peaks"),
        ((1, 2, 3, 4, 1e308), "needs 5 peaks"),
        ((1, 2, 3, 4, 10**400), "needs 5 peaks"),
    ],
)
def test_peaks_that_do_not_rise_or_are_none_are_refused(peaks, why):
    with pytest.raises(ValueError, match=why):
        replace(PAPER.inputs[0], peaks=peaks)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"method": "larsen"}, "The method must be"),
        ({"inputs": PAPER.inputs[:1] * 2}, "must be different"),
        ({"output": replace(PAPER.output, unit="cm/s")}, "must be the speed, in m/s"),
        ({"output": replace(PAPER.output, peaks=(-0.1, 0.1, 0.2, 0.3, 0.4))}, "must lie in 0 to 0.5"),
        ({"output": replace(PAPER.output, peaks=(0.1, 0.2, 0.3, 0.4, 0.6))}, "must lie in 0 to 0.5"),
        ({"output": replace(PAPER.output, peaks=(0.1, 0.2, 0.3, 0.309, 0.4))}, "at least 0.01 m/s apart"),
        ({"table": PAPER.table[:4]}, "5 rows of 5 rules"),
        ({"table": (*PAPER.table[:4], (0, 1, 2, 3))}, "5 rows of 5 rules"),
        ({"table": (*PAPER.table[:4], (0, None, 2, 3, 4))}, r"Rule 22 \(infrared VF, sonar N\) is missing"),
        ({"table": (*PAPER.table[:4], (0, 1, 2, 3, 5))}, r"Rule 25 \(infrared VF, sonar VF\) is missing"),
        ({"table": ((-1, 0, 0, 0, 0), *PAPER.table[1:])}, r"Rule 1 \(infrared VN, sonar VN\) is missing"),
    ],
)
def test_a_rule_set_that_is_none_is_refused(change, why):
    with pytest.raises(ValueError, match=why):
        replace(PAPER, **change)
