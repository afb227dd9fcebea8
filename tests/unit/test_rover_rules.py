"""Which rule sets a rover may drive by: it has the readings, and it stops before what its infrared sensor sees."""

from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robots.kit.contract.errors import BadRequest
from robots.kit.drivers.srv1.rules import READINGS, braking, rules_of
from robots.kit.rovers.fuzzy import PAPER, speed
from robots.kit.rovers.fuzzy_check import check
from robots.kit.rovers.fuzzy_text import write
from tests.unit.fuzzy_sets import METHODS, apart, tables, thousandths

ROVER = braking()
TEXT = write(PAPER)


@pytest.mark.parametrize("method", ["sugeno", "mamdani"])
def test_the_papers_rules_may_be_driven(method):
    rules = replace(PAPER, method=method)
    assert rules_of(write(rules)) == rules


def accepted(rules):
    try:
        check(rules, READINGS, ROVER)
    except ValueError:
        return False
    return True


cautious = st.tuples(*[st.tuples(*[st.integers(0, i + 1)] * 5) for i in range(4)], st.tuples(*[st.integers(0, 4)] * 5))
slow = st.builds(apart, st.integers(0, 100), st.lists(st.integers(10, 90), min_size=4, max_size=4))


@given(
    thousandths(10, 1000), cautious | tables, slow.filter(lambda s: s[-1] <= 0.5), METHODS, st.booleans(), st.data(),
    st.integers(0, 12000),
)  # fmt: skip
def test_by_rules_that_are_accepted_the_rover_stops_before_whatever_it_reads(
    at, table, speeds, method, swapped, data, far
):
    infrared, sonar = PAPER.inputs
    inputs = (replace(infrared, peaks=at), sonar)
    if swapped:
        inputs, table = inputs[::-1], tuple(zip(*table, strict=True))
    rules = replace(PAPER, inputs=inputs, output=replace(PAPER.output, peaks=speeds), table=table, method=method)
    assume(accepted(rules))
    distance = data.draw(st.floats(ROVER.stop, ROVER.far))
    readings = (far / 1000, distance) if swapped else (distance, far / 1000)
    v = speed(rules, *readings)
    assert v <= ROVER.most + 1e-9
    assert v * ROVER.reaction_s + v * v / (2 * ROVER.deceleration) <= distance - ROVER.margin + 1e-9


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        # 0.4 m/s takes 0.228 m
        ("rule VN, M: VS", "rule VN, M: VF", r"Rule 3 \(infrared VN, sonar M\) is too fast: 0.40 m/s takes 0.23 m"),
        ("rule N, VF: S", "rule N, VF: VF", r"Rule 10 \(infrared N, sonar VF\) .* counts from 0.15 m on"),
        ("VF 0.75", "VF 0.8", None),
        ("M 0.45, F 0.6, VF 0.75", "M 0.31, F 0.32, VF 0.33", None),
        (
            "VN 0.15, N 0.3, M 0.45, F 0.6",
            "VN 0.02, N 0.03, M 0.04, F 0.05",
            r"Rule 19 \(.*0.32 m/s takes 0.17 m.*0.15 m",
        ),
        ("VF 0.4", "VF 0.41", r"Rule 25 \(infrared VF, sonar VF\) gives up to 0.41 m/s; the rover goes at most 0.4"),
        ("input sonar m", "input sonar cm", "The sonar is read in m, not in cm"),
        ("input sonar m", "input bumper m", "no reading bumper; it has infrared, sonar, "),
        ("input infrared m", "input light %", r"Rule 19 \(light F, sonar F\) is too fast: 0.32 m/s"),
        ("rule VF, N: S\n", "", r"Rule 22 \(infrared VF, sonar N\) is missing"),
    ],
)
def test_rules_that_are_refused_are_named(old, new, why):
    assert old in TEXT
    text = TEXT.replace(old, new, 1)
    if why is None:
        rules_of(text)
    else:
        with pytest.raises(BadRequest, match=why):
            rules_of(text)


def test_a_centroid_beyond_its_peak_is_counted():
    """A triangle that is longer on its right side: a mean stays at its peak, a centroid does not."""
    speeds = (0.0, 0.01, 0.28, 0.29, 0.4)
    mean = replace(PAPER, output=replace(PAPER.output, peaks=speeds), table=((3,) * 5,) * 4 + ((0,) * 5,))
    check(replace(mean, table=((2,) * 5,) * 5), READINGS, ROVER)
    steep = replace(mean, output=replace(mean.output, peaks=(0.0, 0.24, 0.26, 0.27, 0.4)))
    assert accepted(steep)
    assert not accepted(replace(steep, method="mamdani"))


def test_what_lies_beyond_the_reach_of_the_sensor_is_not_seen():
    with pytest.raises(ValueError, match=r"Rule 25 .* counts from 0.20 m on"):
        check(PAPER, READINGS, replace(ROVER, far=0.2))


def test_the_rover_is_as_its_description_says():
    assert (ROVER.deceleration, ROVER.reaction_s, ROVER.stop, ROVER.far, ROVER.most) == (0.8, 0.25, 0.15, 0.8, 0.4)
    assert ROVER.margin == pytest.approx(0.028)
